// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "fuzz/fuzz_target.h"
#include "fuzz/fuzz_trees.h"
#include "support/mrpt_tools.h"

/** \file
 * The compressed part of a serialized object. */

namespace mrpt::fusion::fuzz {

/** The xz data in a serialized object, which ends with it, an end mark (4 bytes) and MRPT's (1). */
class Blob {
 public:
  explicit Blob(const mrpt::serialization::CSerializable& object)
      : bytes_(map_tests::serialized(object)) {
    constexpr std::string_view kMagic(
        "\xFD"
        "7zXZ\0",
        6);
    begin_ = bytes_.rfind(kMagic);
    require(begin_ != std::string::npos && begin_ >= kLength, "the object has a compressed part");
  }

  /** The content of the compressed part. */
  std::string plain() const {
    return xzDecompressed(std::string_view(bytes_).substr(begin_, bytes_.size() - begin_ - kEnd));
  }

  /** The serialized object with another content of the compressed part. */
  std::string replacedBy(std::string_view plain) const {
    const std::string blob = xzCompressed(plain);
    return bytes_.substr(0, begin_ - kLength) + Output().put(uint64_t{blob.size()}).bytes() + blob +
           bytes_.substr(bytes_.size() - kEnd);
  }

 private:
  static constexpr size_t kLength = 8, kEnd = 5;
  std::string bytes_;
  size_t begin_ = 0;
};

}  // namespace mrpt::fusion::fuzz
