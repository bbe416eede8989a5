// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Packs bytes with Zstandard and LZMA. */
#include "fusion_base/packing.h"

#include <lzma.h>
#include <zstd.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <new>
#include <vector>

#include "fusion_base/byte_reader.h"

namespace mrpt::fusion {
namespace {

/** Level of Zstandard. The sum of the time for packing and of 8 us per byte, on maps of 50k to 85k
 * occupied voxels, is within 1 % of the least sum of all levels. Levels with smaller sums take up
 * to 10 times as long to pack. */
constexpr int kZstdLevel = 9;
/** Largest window for unpacking, as a power of 2: bounds the memory. No level needs more. */
constexpr int kMostZstdWindow = 24;
constexpr uint64_t kMostLzmaMemory = uint64_t{1} << 28U;
constexpr std::string_view kZstdMagic = "\x28\xB5\x2F\xFD";

const uint8_t* bytePointer(std::string_view bytes) {
  return reinterpret_cast<const uint8_t*>(bytes.data());
}

std::string zstdPacked(std::string_view bytes) {
  const std::unique_ptr<ZSTD_CCtx, decltype(&::ZSTD_freeCCtx)> context(::ZSTD_createCCtx(),
                                                                       &::ZSTD_freeCCtx);
  if (!context) throw std::bad_alloc();
  ::ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kZstdLevel);
  ::ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
  std::string out(::ZSTD_compressBound(bytes.size()), '\0');
  const size_t size =
      ::ZSTD_compress2(context.get(), out.data(), out.size(), bytes.data(), bytes.size());
  if (::ZSTD_isError(size)) throw std::bad_alloc();
  out.resize(size);
  return out;
}

std::string lzmaPacked(std::string_view bytes) {
  lzma_options_lzma options;
  lzma_lzma_preset(&options, 9 | LZMA_PRESET_EXTREME);
  constexpr size_t kSmallest = LZMA_DICT_SIZE_MIN, kLargest = size_t{1} << 26U;
  options.dict_size = static_cast<uint32_t>(std::clamp(bytes.size(), kSmallest, kLargest));
  options.pb = 0;  // bytes have no alignment
  lzma_filter filters[] = {{LZMA_FILTER_LZMA2, &options}, {LZMA_VLI_UNKNOWN, nullptr}};
  std::string out(lzma_stream_buffer_bound(bytes.size()), '\0');
  size_t size = 0;
  if (::lzma_stream_buffer_encode(filters, LZMA_CHECK_CRC32, nullptr, bytePointer(bytes),
                                  bytes.size(), reinterpret_cast<uint8_t*>(out.data()), &size,
                                  out.size()) != LZMA_OK)
    throw std::bad_alloc();
  out.resize(size);
  return out;
}

/** Unpacks one piece after the other. */
class Unpacker {
 public:
  Unpacker() = default;
  virtual ~Unpacker() = default;
  Unpacker(const Unpacker&) = delete;
  Unpacker& operator=(const Unpacker&) = delete;

  enum class State { More, End, Damaged };
  /** Fills a block with the next bytes. It is full as long as the state is State::More.
   * \param[out] size Number of bytes. */
  virtual State next(std::vector<char>& block, size_t& size) = 0;
};

class LzmaUnpacker : public Unpacker {
 public:
  explicit LzmaUnpacker(std::string_view bytes) {
    if (::lzma_stream_decoder(&stream_, kMostLzmaMemory, 0) != LZMA_OK) throw std::bad_alloc();
    stream_.next_in = bytePointer(bytes);
    stream_.avail_in = bytes.size();
  }
  ~LzmaUnpacker() override { ::lzma_end(&stream_); }
  State next(std::vector<char>& block, size_t& size) override {
    stream_.next_out = reinterpret_cast<uint8_t*>(block.data());
    stream_.avail_out = block.size();
    lzma_ret state = LZMA_OK;
    while (state == LZMA_OK && stream_.avail_out > 0) state = ::lzma_code(&stream_, LZMA_FINISH);
    size = block.size() - stream_.avail_out;
    if (state == LZMA_OK) return State::More;
    return state == LZMA_STREAM_END && stream_.avail_in == 0 ? State::End : State::Damaged;
  }

 private:
  lzma_stream stream_ = LZMA_STREAM_INIT;
};

class ZstdUnpacker : public Unpacker {
 public:
  explicit ZstdUnpacker(std::string_view bytes)
      : context_(::ZSTD_createDCtx(), &::ZSTD_freeDCtx), in_{bytes.data(), bytes.size(), 0} {
    if (!context_) throw std::bad_alloc();
    ::ZSTD_DCtx_setParameter(context_.get(), ZSTD_d_windowLogMax, kMostZstdWindow);
  }
  State next(std::vector<char>& block, size_t& size) override {
    ZSTD_outBuffer out{block.data(), block.size(), 0};
    State state = State::More;
    while (state == State::More && out.pos < out.size) {
      const size_t before = in_.pos + out.pos;
      const size_t left = ::ZSTD_decompressStream(context_.get(), &out, &in_);
      if (::ZSTD_isError(left))
        state = State::Damaged;
      else if (left == 0)
        state = in_.pos == in_.size ? State::End : State::Damaged;
      else if (in_.pos + out.pos == before)
        state = State::Damaged;  // it wants more bytes
    }
    size = out.pos;
    return state;
  }

 private:
  std::unique_ptr<ZSTD_DCtx, decltype(&::ZSTD_freeDCtx)> context_;
  ZSTD_inBuffer in_;
};

std::string unpackedBy(Unpacker& unpacker, const UnpackedLimit& limit) {
  uint64_t most = std::numeric_limits<uint64_t>::max();  // known from the first block on
  std::string out;
  std::vector<char> block(size_t{1} << 18U);
  auto state = Unpacker::State::More;
  while (state == Unpacker::State::More && out.size() <= most) {
    const bool is_first = out.empty();
    size_t size = 0;
    state = unpacker.next(block, size);
    out.append(block.data(), size);
    if (is_first && state == Unpacker::State::More) most = limit(out);
  }
  if (state != Unpacker::State::End) corrupt("the map's compressed data is truncated or damaged");
  return out;
}

}  // namespace

std::string packed(std::string_view bytes, Packing packing) {
  return packing == Packing::Fast ? zstdPacked(bytes) : lzmaPacked(bytes);
}

Packing packingOf(std::string_view bytes) {
  return bytes.substr(0, kZstdMagic.size()) == kZstdMagic ? Packing::Fast : Packing::Smallest;
}

std::string unpacked(std::string_view bytes, const UnpackedLimit& limit) {
  if (packingOf(bytes) == Packing::Fast) {
    ZstdUnpacker unpacker(bytes);
    return unpackedBy(unpacker, limit);
  }
  LzmaUnpacker unpacker(bytes);
  return unpackedBy(unpacker, limit);
}

}  // namespace mrpt::fusion
