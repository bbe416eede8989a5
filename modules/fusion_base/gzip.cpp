// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Unpacks gzip data with zlib. */
#include "fusion_base/gzip.h"

#define ZLIB_CONST  // input is const
#include <zlib.h>

#include <algorithm>
#include <new>
#include <stdexcept>
#include <vector>

namespace mrpt::fusion {
namespace {

constexpr std::string_view kMagic = "\x1f\x8b";
constexpr size_t kBlockBytes = size_t{1} << 18U;

/** A stream of packed parts that follow each other. */
class Unpacking {
 public:
  explicit Unpacking(std::string_view bytes) : rest_(bytes), block_(kBlockBytes) {
    constexpr int kGzipFormat = 16;
    if (::inflateInit2(&stream_, MAX_WBITS + kGzipFormat) != Z_OK) throw std::bad_alloc();
  }
  ~Unpacking() { ::inflateEnd(&stream_); }
  Unpacking(const Unpacking&) = delete;
  Unpacking& operator=(const Unpacking&) = delete;

  enum class State { More, End, Damaged };

  /** Unpacks the next block, of at most \a most bytes, and appends it to \a out. */
  State next(size_t most, std::string& out) {
    if (stream_.avail_in == 0) {  // zlib counts in 32 bits
      stream_.next_in = reinterpret_cast<const Bytef*>(rest_.data());
      stream_.avail_in = static_cast<uInt>(std::min<size_t>(rest_.size(), 1U << 30U));
      rest_.remove_prefix(stream_.avail_in);
    }
    const size_t wanted = std::min(most, block_.size());
    stream_.next_out = block_.data();
    stream_.avail_out = static_cast<uInt>(wanted);
    const int state = ::inflate(&stream_, Z_NO_FLUSH);
    out.append(reinterpret_cast<const char*>(block_.data()), wanted - stream_.avail_out);
    if (state == Z_STREAM_END) return startNextPart() ? State::More : State::End;
    return state == Z_OK ? State::More : State::Damaged;
  }

 private:
  bool startNextPart() {
    const std::string_view left(reinterpret_cast<const char*>(stream_.next_in), stream_.avail_in);
    return isGzip(left) && ::inflateReset(&stream_) == Z_OK;
  }

  z_stream stream_{};
  std::string_view rest_;
  std::vector<Bytef> block_;
};

}  // namespace

bool isGzip(std::string_view bytes) { return bytes.substr(0, kMagic.size()) == kMagic; }

std::string gunzipped(std::string_view bytes, size_t most) {
  Unpacking unpacking(bytes);
  std::string out;
  auto state = Unpacking::State::More;
  while (state == Unpacking::State::More && out.size() <= most)
    state = unpacking.next(kBlockBytes, out);
  if (out.size() > most)
    throw std::runtime_error("the compressed data unpacks to more than " + std::to_string(most) +
                             " bytes: too much for a file of " + std::to_string(bytes.size()) +
                             " bytes");
  if (state != Unpacking::State::End)
    throw std::runtime_error("the compressed data ends early or is damaged");
  return out;
}

std::string gunzippedBeginning(std::string_view bytes, size_t most) {
  Unpacking unpacking(bytes);
  std::string out;
  while (out.size() < most && unpacking.next(most - out.size(), out) == Unpacking::State::More) {
  }
  return out;
}

}  // namespace mrpt::fusion
