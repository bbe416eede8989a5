// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Loads the module of the link over DDS. */
#include "fusion_link/dds_link.h"

#include <stdexcept>

#include "fusion_base/module.h"

namespace mrpt::fusion {

std::unique_ptr<Link> openLink([[maybe_unused]] const DdsSettings& settings) {
#ifdef DDS_MODULE
  const auto open =
      reinterpret_cast<OpenDdsLink>(functionOfModule(DDS_MODULE, kOpenDdsLink, "the link"));
  return std::unique_ptr<Link>(open(settings));
#else
  throw std::runtime_error(
      "robots join by CycloneDDS (Debian package cyclonedds-dev), without which this program was "
      "built");
#endif
}

}  // namespace mrpt::fusion
