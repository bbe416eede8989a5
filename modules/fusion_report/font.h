// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

/** \file
 * A font of fixed width: 9x15 of the X Window System, which is in the public domain. */

namespace mrpt::fusion {

constexpr int kGlyphWidth = 9;    ///< Distance from a character to the next one, pixels
constexpr int kGlyphHeight = 14;  ///< Rows of a character, pixels; an empty row is above them

/** The rows of a character, from top to bottom. Bit x is the pixel in column x. */
using Glyph = std::array<uint16_t, kGlyphHeight>;

/** Returns the glyph of an ASCII character. Other characters look like a space. */
const Glyph& glyphOf(char character);

}  // namespace mrpt::fusion
