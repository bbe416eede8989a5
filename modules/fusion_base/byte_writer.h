// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <type_traits>

/** \file
 * Writing of values as bytes, the inverse of byte_reader.h. */

namespace mrpt::fusion {

/** Appends the bytes of a value, in the byte order of the machine. */
template <class T>
void appendValue(const T& value, std::string& out) {
  static_assert(std::is_trivially_copyable_v<T>);
  out.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

}  // namespace mrpt::fusion
