// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/io/CStream.h>

#include <cstdint>
#include <string>
#include <string_view>

struct gzFile_s;

/** \file
 * Bytes of files that may be gz-compressed. */

namespace mrpt::fusion {

/** A file as a stream for the archives of MRPT. The file may be gz-compressed. MRPT's own stream
 * does not report that a file ends within a number or a compressed block. This stream throws. */
class GzStream : public mrpt::io::CStream {
 public:
  /** \exception std::runtime_error If the file cannot be opened. */
  explicit GzStream(const std::string& path);
  ~GzStream() override;
  GzStream(const GzStream&) = delete;
  GzStream& operator=(const GzStream&) = delete;

  /** \exception ReadingStopped If the file ends early or is damaged, or if it unpacks to more than
   * 64 MB and 32 times its size. Recordings and maps have 2 to 15 times. */
  size_t Read(void* buffer, size_t count) override;
  /** Number of uncompressed bytes that were read. */
  uint64_t getPosition() const override { return position_; }

  size_t Write(const void* buffer, size_t count) override;
  uint64_t Seek(int64_t offset, TSeekOrigin origin) override;
  uint64_t getTotalBytesCount() const override;

 private:
  /** Bounds the bytes that a compressed file unpacks to. */
  void checkProportion() const;

  gzFile_s* file_;
  uint64_t position_ = 0;
};

/** Compresses bytes in memory, in the format of gzip. MRPT's compress_gz_data_block() uses a named
 * pipe in /tmp, and its results were truncated. */
std::string gzCompressed(std::string_view bytes);

}  // namespace mrpt::fusion
