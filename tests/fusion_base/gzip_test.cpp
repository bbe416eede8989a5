// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the unpacking of gzip data. */
#include "fusion_base/gzip.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <stdexcept>

using mrpt::fusion::gunzipped;
using mrpt::fusion::gunzippedBeginning;
using mrpt::fusion::isGzip;

namespace {

std::string packed(std::string bytes) {
  z_stream stream{};
  EXPECT_EQ(Z_OK, ::deflateInit2(&stream, 9, Z_DEFLATED, MAX_WBITS + 16, 8, Z_DEFAULT_STRATEGY));
  std::string out(::deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(Z_STREAM_END, ::deflate(&stream, Z_FINISH));
  out.resize(stream.total_out);
  ::deflateEnd(&stream);
  return out;
}

std::string manyBytes() {
  std::string bytes;
  for (unsigned i = 0; i < 1'000'000; i++) bytes += static_cast<char>(i * i / 7);
  return bytes;
}

}  // namespace

TEST(Gzip, IsUnpacked) {
  const std::string bytes = manyBytes();
  EXPECT_TRUE(isGzip(packed(bytes)));
  EXPECT_FALSE(isGzip(bytes));
  EXPECT_EQ(bytes, gunzipped(packed(bytes), bytes.size()));
  EXPECT_EQ("", gunzipped(packed(""), 10));
  EXPECT_EQ(bytes + "and more", gunzipped(packed(bytes) + packed("and more"), 2 * bytes.size()))
      << "parts that follow each other";
}

TEST(Gzip, ThatUnpacksToTooMuchIsAnError) {
  const std::string bomb = packed(std::string(20 << 20, '\0'));
  EXPECT_LT(bomb.size(), 100'000U);
  EXPECT_THROW(gunzipped(bomb, 1 << 20), std::runtime_error);
}

TEST(Gzip, ThatIsDamagedIsAnError) {
  const std::string good = packed(manyBytes());
  for (size_t n = 0; n < good.size(); n += 1 + good.size() / 50)
    EXPECT_THROW(gunzipped(good.substr(0, n), 2 << 20), std::runtime_error) << n;
  std::string damaged = good;
  damaged[good.size() / 2] ^= 0x40;
  EXPECT_THROW(gunzipped(damaged, 2 << 20), std::runtime_error);
}

TEST(Gzip, HasABeginning) {
  EXPECT_EQ(manyBytes().substr(0, 64), gunzippedBeginning(packed(manyBytes()).substr(0, 4096), 64));
  EXPECT_EQ("abc", gunzippedBeginning(packed("abc"), 64));
  EXPECT_EQ("", gunzippedBeginning("\x1f\x8b damaged", 64));
}
