// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Draws rectangles and text, and writes PNG with libpng. */

#include "fusion_report/image.h"

#include <png.h>

#include <algorithm>
#include <stdexcept>

#include "fusion_report/font.h"

namespace mrpt::fusion {

namespace {
constexpr size_t kChannels = 3;
}

Image::Image(int width, int height)
    : width_(width),
      height_(height),
      channels_(kChannels * static_cast<size_t>(width) * static_cast<size_t>(height), 255) {}

size_t Image::offsetOf(int x, int y) const {
  return kChannels *
         (static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x));
}

Colour Image::at(int x, int y) const {
  const size_t i = offsetOf(x, y);
  return {channels_[i], channels_[i + 1], channels_[i + 2]};
}

void Image::fillRectangle(int x0, int y0, int x1, int y1, Colour colour) {
  for (int y = std::max(y0, 0); y <= std::min(y1, height_ - 1); y++)
    for (int x = std::max(x0, 0); x <= std::min(x1, width_ - 1); x++) {
      const size_t i = offsetOf(x, y);
      channels_[i] = colour.red;
      channels_[i + 1] = colour.green;
      channels_[i + 2] = colour.blue;
    }
}

void Image::drawText(int x, int y, const std::string& text, Colour colour) {
  const int top = y + 1;  // the font is 15 rows high, and its first row is empty
  for (const char character : text) {
    const Glyph& glyph = glyphOf(character);
    for (int row = 0; row < kGlyphHeight; row++)
      for (int column = 0; column < kGlyphWidth; column++)
        if (glyph[static_cast<size_t>(row)] >> column & 1)
          fillRectangle(x + column, top + row, x + column, top + row, colour);
    x += kGlyphWidth;
  }
}

std::string Image::toPng() const {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width_);
  image.height = static_cast<png_uint_32>(height_);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, 0);
  if (!png_image_write_to_memory(&image, bytes.data(), &size, 0, channels_.data(), 0, nullptr))
    throw std::runtime_error(std::string("PNG: ") + image.message);
  bytes.resize(size);
  return bytes;
}

}  // namespace mrpt::fusion
