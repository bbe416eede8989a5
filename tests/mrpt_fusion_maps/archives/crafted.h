// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>
#include <set>
#include <string>
#include <string_view>

#include "support/mrpt_tools.h"

/** \file
 * Streams that no writer writes. */

namespace map_tests {

/** Returns a text in which the first occurrence of a part is replaced. */
inline std::string replaced(std::string text, std::string_view part, std::string_view by) {
  const size_t at = text.find(part);
  EXPECT_NE(at, std::string::npos);
  if (at != std::string::npos) text.replace(at, part.size(), by);
  return text;
}

/** Returns the bytes of a value. */
template <class T>
std::string bytesOfValue(T value) {
  std::string bytes(sizeof(value), '\0');
  std::memcpy(bytes.data(), &value, sizeof(value));
  return bytes;
}

/** Returns the serialized object in which a number has another value. */
template <class T>
std::string withNumber(const std::string& bytes, T number, T other) {
  return replaced(bytes, bytesOfValue(number), bytesOfValue(other));
}

/** Returns an object that holds an object ... that holds the innermost object.
 * \param[in] outer A serialized object.
 * \param[in] held The serialized object in it. The objects that are nested replace it.
 * \param[in] innermost The serialized innermost object. */
inline std::string nested(const std::string& outer, const std::string& held, size_t times,
                          const std::string& innermost) {
  const size_t at = outer.find(held);
  EXPECT_NE(at, std::string::npos);
  const std::string before = outer.substr(0, at), after = outer.substr(at + held.size());
  std::string bytes;
  for (size_t i = 0; i < times; i++) bytes += before;
  bytes += innermost;
  for (size_t i = 0; i < times; i++) bytes += after;
  return bytes;
}

}  // namespace map_tests
