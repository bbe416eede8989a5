// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads and writes gz-compressed bytes with zlib. */

#include "mrpt_fusion_maps/recordings/gz_stream.h"

#include <mrpt/core/exceptions.h>

#define ZLIB_CONST  // input is const
#include <zlib.h>

#include <algorithm>
#include <new>
#include <stdexcept>
#include <vector>

#include "mrpt_fusion_maps/archives/guarded_archive.h"

namespace mrpt::fusion {

GzStream::GzStream(const std::string& path) : file_(::gzopen(path.c_str(), "rb")) {
  if (!file_) throw std::runtime_error("cannot be opened");
  ::gzbuffer(file_, 1U << 18U);
}

GzStream::~GzStream() { ::gzclose(file_); }

size_t GzStream::Read(void* buffer, size_t count) {
  auto* to = static_cast<char*>(buffer);
  size_t done = 0;
  while (done < count) {
    const auto block = static_cast<unsigned>(std::min<size_t>(count - done, 1U << 30U));
    const int n = ::gzread(file_, to + done, block);
    if (n <= 0) break;
    done += static_cast<size_t>(n);
  }
  position_ += done;
  int error = Z_OK;
  ::gzerror(file_, &error);
  if (error != Z_OK && error != Z_STREAM_END)
    throw ReadingStopped("the compressed data ends early or is damaged");
  if (done < count && done > 0) throw ReadingStopped("the file ends early");
  checkProportion();
  return done;
}

void GzStream::checkProportion() const {
  constexpr uint64_t kBytes = uint64_t{1} << 26U, kPerCompressedByte = 32;
  if (position_ <= kBytes || ::gzdirect(file_)) return;
  const auto compressed = static_cast<uint64_t>(std::max<z_off_t>(0, ::gzoffset(file_)));
  if (position_ > kBytes + kPerCompressedByte * compressed)
    throw ReadingStopped("the compressed data unpacks to more bytes than maps and recordings have");
}

size_t GzStream::Write(const void*, size_t) { THROW_EXCEPTION("the stream is for reading only"); }
uint64_t GzStream::Seek(int64_t, TSeekOrigin) { THROW_EXCEPTION("the stream cannot seek"); }
uint64_t GzStream::getTotalBytesCount() const {
  THROW_EXCEPTION("the size of the stream is unknown");
}

std::string gzCompressed(std::string_view bytes) {
  z_stream stream{};
  constexpr int kGzipFormat = 16;
  if (::deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, MAX_WBITS + kGzipFormat, 8,
                     Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  std::string compressed;
  std::vector<Bytef> block(1U << 18U);
  int state = Z_OK;
  while (state != Z_STREAM_END) {
    if (stream.avail_in == 0 && !bytes.empty()) {  // zlib counts in 32 bits
      const auto next = bytes.substr(0, 1U << 30U);
      stream.next_in = reinterpret_cast<const Bytef*>(next.data());
      stream.avail_in = static_cast<uInt>(next.size());
      bytes.remove_prefix(next.size());
    }
    stream.next_out = block.data();
    stream.avail_out = static_cast<uInt>(block.size());
    state = ::deflate(&stream, bytes.empty() ? Z_FINISH : Z_NO_FLUSH);
    compressed.append(block.begin(), block.end() - stream.avail_out);
  }
  ::deflateEnd(&stream);
  return compressed;
}

}  // namespace mrpt::fusion
