// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/** \file
 * A picture in memory, and the PNG file of it. */

namespace mrpt::fusion {

/** A colour; each channel is in [0,255]. */
struct Colour {
  uint8_t red = 0, green = 0, blue = 0;
};
constexpr Colour kBlack{0, 0, 0}, kWhite{255, 255, 255};

/** A white picture to draw on. Drawing outside of it is cut off. */
class Image {
 public:
  /** \param[in] width,height Size, pixels, at least 1. */
  Image(int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }
  /** Returns the colour of a pixel inside the picture. The origin is the upper left corner. */
  Colour at(int x, int y) const;

  /** Fills a rectangle. \param[in] x0,y0 Upper left corner. \param[in] x1,y1 Lower right corner,
   * which belongs to the rectangle. */
  void fillRectangle(int x0, int y0, int x1, int y1, Colour colour);
  /** Writes one line of ASCII text, see font.h. \param[in] x,y Upper left corner. */
  void drawText(int x, int y, const std::string& text, Colour colour);

  /** Returns the picture as the bytes of a PNG file. \exception std::runtime_error If libpng fails.
   */
  std::string toPng() const;

 private:
  size_t offsetOf(int x, int y) const;

  int width_, height_;
  std::vector<uint8_t> channels_;  ///< Red, green and blue of each pixel, row by row
};

}  // namespace mrpt::fusion
