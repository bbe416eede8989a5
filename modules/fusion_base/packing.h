// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

/** \file
 * Packs bytes, and unpacks bytes from outside with a limit. */

namespace mrpt::fusion {

/** How bytes are packed. Both ways have a checksum. */
enum class Packing {
  Fast,     ///< Zstandard: little time until the bytes have passed a link of 1 Mbit/s
  Smallest  ///< LZMA: a tenth less bytes, ten times the time
};

/** Returns the packed bytes. */
std::string packed(std::string_view bytes, Packing packing);

/** Returns how bytes were packed. */
Packing packingOf(std::string_view bytes);

/** Returns the largest number of unpacked bytes, told by the first unpacked bytes. */
using UnpackedLimit = std::function<uint64_t(std::string_view beginning)>;

/** Inverts packed(), for each Packing. All packed bytes must be used.
 * \param[in] bytes The packed bytes.
 * \param[in] limit Gets at least 24 unpacked bytes, unless there are less. Its exceptions pass.
 * \exception std::runtime_error If the data is truncated or damaged, or has more unpacked bytes
 * than the limit. */
std::string unpacked(std::string_view bytes, const UnpackedLimit& limit);

}  // namespace mrpt::fusion
