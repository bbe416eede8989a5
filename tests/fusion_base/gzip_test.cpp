// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the unpacking of gzip data. */
#include "fusion_base/gzip.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "support/gzip_bytes.h"

using map_tests::gzipped;
using mrpt::fusion::gunzipped;
using mrpt::fusion::gunzippedBeginning;
using mrpt::fusion::isGzip;

namespace {

std::string manyBytes() {
  std::string bytes;
  for (unsigned i = 0; i < 1'000'000; i++) bytes += static_cast<char>(i * i / 7);
  return bytes;
}

}  // namespace

TEST(Gzip, IsUnpacked) {
  const std::string bytes = manyBytes();
  EXPECT_TRUE(isGzip(gzipped(bytes)));
  EXPECT_FALSE(isGzip(bytes));
  EXPECT_EQ(bytes, gunzipped(gzipped(bytes), bytes.size()));
  EXPECT_EQ("", gunzipped(gzipped(""), 10));
  EXPECT_EQ(bytes + "and more", gunzipped(gzipped(bytes) + gzipped("and more"), 2 * bytes.size()))
      << "parts that follow each other";
}

TEST(Gzip, ThatUnpacksToTooMuchIsAnError) {
  const std::string bomb = gzipped(std::string(20 << 20, '\0'));
  EXPECT_LT(bomb.size(), 100'000U);
  EXPECT_THROW(gunzipped(bomb, 1 << 20), std::runtime_error);
}

TEST(Gzip, ThatIsDamagedIsAnError) {
  const std::string good = gzipped(manyBytes());
  for (size_t n = 0; n < good.size(); n += 1 + good.size() / 50)
    EXPECT_THROW(gunzipped(good.substr(0, n), 2 << 20), std::runtime_error) << n;
  std::string damaged = good;
  damaged[good.size() / 2] ^= 0x40;
  EXPECT_THROW(gunzipped(damaged, 2 << 20), std::runtime_error);
}

TEST(Gzip, HasABeginning) {
  EXPECT_EQ(manyBytes().substr(0, 64),
            gunzippedBeginning(gzipped(manyBytes()).substr(0, 4096), 64));
  EXPECT_EQ("abc", gunzippedBeginning(gzipped("abc"), 64));
  EXPECT_EQ("", gunzippedBeginning("\x1f\x8b damaged", 64));
}
