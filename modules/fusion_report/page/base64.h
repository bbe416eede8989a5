// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

/** \file
 * Bytes as text. */

namespace mrpt::fusion {

/** Returns bytes in base64, with padding. Cost: O(bytes). */
std::string toBase64(std::string_view bytes);

}  // namespace mrpt::fusion
