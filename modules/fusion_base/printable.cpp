// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Escapes control characters and bytes that are not UTF-8. */
#include "fusion_base/printable.h"

#include <cstdint>
#include <cstdio>

namespace mrpt::fusion {
namespace {

/** Returns the number of bytes of the printable UTF-8 character at the beginning of a text. 0:
 * there is no such character. */
size_t characterAt(std::string_view text) {
  const auto byte = [&](size_t i) { return static_cast<uint8_t>(text[i]); };
  const uint8_t first = byte(0);
  if (first < 0x80) return first >= 0x20 && first != 0x7F ? 1 : 0;
  const size_t size = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < size) return 0;
  for (size_t i = 1; i < size; i++)
    if ((byte(i) & 0xC0U) != 0x80) return 0;
  // U+0080 to U+009F control a terminal. Longer forms than needed could hide them.
  const bool is_control = first == 0xC2 && byte(1) < 0xA0;
  const bool is_overlong = (first == 0xE0 && byte(1) < 0xA0) || (first == 0xF0 && byte(1) < 0x90);
  return is_control || is_overlong ? 0 : size;
}

}  // namespace

std::string printable(std::string_view text) { return printable(text, std::string_view::npos); }

std::string printable(std::string_view text, size_t most) {
  std::string out;
  for (size_t count = 0; !text.empty(); count++) {
    if (count == most) return out + "...";
    size_t size = characterAt(text);
    if (size > 0) {
      out += text.substr(0, size);
    } else {
      char escaped[8];
      std::snprintf(escaped, sizeof(escaped), "\\x%02x", static_cast<uint8_t>(text[0]));
      out += escaped;
      size = 1;
    }
    text.remove_prefix(size);
  }
  return out;
}

}  // namespace mrpt::fusion
