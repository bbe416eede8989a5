// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "fusion_team/link/link.h"

/** \file
 * The link over DDS. It is in a module of its own, which only programs that use it load: CycloneDDS
 * brings 10 libraries, and a build may be without it. */

namespace mrpt::fusion {

/** Settings of a link over DDS. */
struct DdsSettings {
  std::string robot;               ///< Name of this robot
  uint32_t domain = 0;             ///< Number of the domain, 0 to 232: robots of one domain meet
  std::vector<std::string> peers;  ///< Addresses of robots; empty: robots are found by multicast
};

/** Largest number of a domain. */
constexpr uint32_t kMostDomain = 232;

/** Loads the module, and opens a link over DDS.
 * \exception std::runtime_error If the module cannot be loaded, if this program was built without
 * CycloneDDS, or see OpenDdsLink. */
std::unique_ptr<Link> openLink(const DdsSettings& settings);

/** Opens a link over DDS. The environment variable CYCLONEDDS_URI adds settings of CycloneDDS.
 * \param[in] settings See DdsSettings.
 * \return The link. The caller owns it.
 * \exception std::runtime_error With the reason of CycloneDDS, or if an address has other
 * characters than letters, digits and `.:%-[]`. */
using OpenDdsLink = Link* (*)(const DdsSettings& settings);

/** Name of the function in the module. */
constexpr const char* kOpenDdsLink = "openDdsLink";

}  // namespace mrpt::fusion
