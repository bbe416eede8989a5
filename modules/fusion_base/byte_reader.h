// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>

/** \file
 * Bounds-checked reading of bytes. */

namespace mrpt::fusion {

/** Throws std::runtime_error with the message \a why. */
[[noreturn]] inline void corrupt(const std::string& why) { throw std::runtime_error(why); }

/** Reads values from the front of a byte range. Throws std::runtime_error at its end. */
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  size_t size() const { return bytes_.size(); }

  template <class T>
  T take() {
    T value;
    std::memcpy(&value, takeBytes(sizeof(T)).data(), sizeof(T));
    return value;
  }
  std::string_view takeBytes(size_t n) {
    if (bytes_.size() < n) corrupt("the map's data is truncated");
    const auto taken = bytes_.substr(0, n);
    bytes_.remove_prefix(n);
    return taken;
  }

 private:
  std::string_view bytes_;
};

}  // namespace mrpt::fusion
