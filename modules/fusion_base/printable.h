// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

/** \file
 * Text from outside, made safe for a terminal. */

namespace mrpt::fusion {

/** Returns a text in which control characters and bytes that are not UTF-8 are written as `\xNN`.
 * A terminal would obey control characters. Other characters stay as they are. */
std::string printable(std::string_view text);

/** Returns the first \a most characters of printable(), followed by "..." if the text is longer. */
std::string printable(std::string_view text, size_t most);

}  // namespace mrpt::fusion
