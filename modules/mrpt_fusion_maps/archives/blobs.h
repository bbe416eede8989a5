// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cstdint>
#include <string>

/** \file
 * Large fields in the archives of MRPT. A damaged stream causes an exception. */

namespace mrpt::fusion {

/** Writes the number of bytes, then the bytes. */
inline void writeBlob(mrpt::serialization::CArchive& out, const std::string& bytes) {
  out << static_cast<uint64_t>(bytes.size());
  if (!bytes.empty()) out.WriteBuffer(bytes.data(), bytes.size());
}

/** Reads bytes in blocks, so that a wrong length reaches the end of the stream before much memory
 * is allocated. \exception std::exception If the stream ends early. */
inline std::string readBytes(mrpt::serialization::CArchive& in, uint64_t size) {
  constexpr uint64_t kBlock = 1 << 20;
  std::string bytes;
  while (bytes.size() < size) {
    const auto n = static_cast<size_t>(std::min(kBlock, size - bytes.size()));
    bytes.resize(bytes.size() + n);
    if (in.ReadBuffer(&bytes[bytes.size() - n], n) != n)
      THROW_EXCEPTION("corrupt stream: it ends early");
  }
  return bytes;
}

/** Reads what writeBlob() has written. \exception std::exception As readBytes(). */
inline std::string readBlob(mrpt::serialization::CArchive& in) {
  return readBytes(in, in.ReadAs<uint64_t>());
}

/** The byte that MRPT writes at the end of each object. */
constexpr uint8_t kObjectEnd = 0x88;

/** Marks the end of an object. If a stream ends within a number, MRPT reads a wrong number and does
 * not throw. The mark detects this. */
inline void writeEndMark(mrpt::serialization::CArchive& out) { out << uint32_t{0x50524f42}; }
/** Reads the mark. \exception std::exception If the stream has ended early. */
inline void readEndMark(mrpt::serialization::CArchive& in) {
  uint32_t mark = 0;
  in >> mark;
  if (mark != 0x50524f42) THROW_EXCEPTION("corrupt stream: it ends early");
}

}  // namespace mrpt::fusion
