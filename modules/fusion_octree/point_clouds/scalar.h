// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

/** \file
 * The numbers of point clouds as bytes. */

namespace mrpt::fusion {

/** Type of a number in a point cloud. */
enum class Scalar : unsigned char {
  Int8,
  UInt8,
  Int16,
  UInt16,
  Int32,
  UInt32,
  Int64,
  UInt64,
  Float32,
  Float64
};

/** Returns the size of a number, bytes. */
constexpr size_t sizeOf(Scalar type) {
  constexpr size_t kSizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kSizes[static_cast<size_t>(type)];
}

namespace detail {

template <class T>
double valueOf(const char* bytes, bool is_swapped) {
  char ordered[sizeof(T)];
  for (size_t i = 0; i < sizeof(T); i++) ordered[is_swapped ? sizeof(T) - 1 - i : i] = bytes[i];
  T value;
  std::memcpy(&value, ordered, sizeof(T));
  return static_cast<double>(value);
}

}  // namespace detail

/** Returns the number at a place in memory. \param[in] bytes The place: sizeOf(type) bytes.
 * \param[in] type Type of the number. \param[in] is_swapped True if the highest byte comes first
 * (the machine's lowest byte comes first). */
inline double valueAt(const char* bytes, Scalar type, bool is_swapped = false) {
  switch (type) {
    case Scalar::Int8:
      return detail::valueOf<int8_t>(bytes, is_swapped);
    case Scalar::UInt8:
      return detail::valueOf<uint8_t>(bytes, is_swapped);
    case Scalar::Int16:
      return detail::valueOf<int16_t>(bytes, is_swapped);
    case Scalar::UInt16:
      return detail::valueOf<uint16_t>(bytes, is_swapped);
    case Scalar::Int32:
      return detail::valueOf<int32_t>(bytes, is_swapped);
    case Scalar::UInt32:
      return detail::valueOf<uint32_t>(bytes, is_swapped);
    case Scalar::Int64:
      return detail::valueOf<int64_t>(bytes, is_swapped);
    case Scalar::UInt64:
      return detail::valueOf<uint64_t>(bytes, is_swapped);
    case Scalar::Float32:
      return detail::valueOf<float>(bytes, is_swapped);
    case Scalar::Float64:
      break;
  }
  return detail::valueOf<double>(bytes, is_swapped);
}

}  // namespace mrpt::fusion
