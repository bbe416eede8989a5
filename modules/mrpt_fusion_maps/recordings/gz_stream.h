// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/io/CStream.h>

#include <cstdint>
#include <string>
#include <string_view>

struct gzFile_s;

/** \file
 * Files of MRPT's objects, gz-compressed or not, as bytes. */

namespace mrpt::fusion {

/** A file, gz-compressed or not, as MRPT's archives read it. MRPT's own takes a file that ends
 * early, amid a number or a compressed block, for one that ends there; this one throws. */
class GzStream : public mrpt::io::CStream {
 public:
  /** \exception std::runtime_error If the file cannot be opened. */
  explicit GzStream(const std::string& path);
  ~GzStream() override;
  GzStream(const GzStream&) = delete;
  GzStream& operator=(const GzStream&) = delete;

  size_t Read(void* buffer, size_t count) override;
  /** Bytes read so far, uncompressed. */
  uint64_t getPosition() const override { return position_; }

  size_t Write(const void* buffer, size_t count) override;
  uint64_t Seek(int64_t offset, TSeekOrigin origin) override;
  uint64_t getTotalBytesCount() const override;

 private:
  gzFile_s* file_;
  uint64_t position_ = 0;
};

/** \a bytes in gzip's format, compressed in memory: MRPT's compress_gz_data_block goes through a
 * named pipe in /tmp, and what it returns has been seen cut short. */
std::string gzCompressed(std::string_view bytes);

}  // namespace mrpt::fusion
