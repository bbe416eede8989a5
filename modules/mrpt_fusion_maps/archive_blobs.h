// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cstdint>
#include <string>

/** \file
 * Large fields in MRPT's archives, read so that a damaged stream does no harm. */

namespace mrpt::fusion {

/** Writes a length and so many bytes. */
inline void writeBlob(mrpt::serialization::CArchive& out, const std::string& bytes) {
  out << static_cast<uint64_t>(bytes.size());
  if (!bytes.empty()) out.WriteBuffer(bytes.data(), bytes.size());
}

/** Inverse of writeBlob(). Reads in blocks: a length field that lies runs into the end of the
 * stream before it has taken much memory. \exception std::exception If the stream ends early. */
inline std::string readBlob(mrpt::serialization::CArchive& in) {
  constexpr uint64_t kBlock = 1 << 20;
  uint64_t size = 0;
  in >> size;
  std::string bytes;
  while (bytes.size() < size) {
    const auto n = static_cast<size_t>(std::min(kBlock, size - bytes.size()));
    bytes.resize(bytes.size() + n);
    if (in.ReadBuffer(&bytes[bytes.size() - n], n) != n)
      THROW_EXCEPTION("corrupt stream: it ends early");
  }
  return bytes;
}

/** Ends an object: MRPT takes part of a number for all of it where a stream ends early. */
inline void writeEndMark(mrpt::serialization::CArchive& out) { out << uint32_t{0x50524f42}; }
/** \exception std::exception If the stream ended early. */
inline void readEndMark(mrpt::serialization::CArchive& in) {
  uint32_t mark = 0;
  in >> mark;
  if (mark != 0x50524f42) THROW_EXCEPTION("corrupt stream: it ends early");
}

}  // namespace mrpt::fusion
