// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/fusion/voxel_index.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

namespace mrpt::fusion::test {
namespace {

using Place = std::array<int, 3>;

/** The brute-force twin. */
class MapIndex {
 public:
  explicit MapIndex(const std::vector<octomap::OcTreeKey>& keys) {
    for (uint32_t i = 0; i < keys.size(); i++) index_[{keys[i][0], keys[i][1], keys[i][2]}] = i;
  }
  uint32_t find(const Place& p) const {
    const auto it = index_.find(p);
    return it == index_.end() ? VoxelIndex::kNone : it->second;
  }

 private:
  std::map<Place, uint32_t> index_;
};

/** Different keys drawn from [low, high] along each axis. */
std::vector<octomap::OcTreeKey> randomKeys(size_t n, int low, int high, std::mt19937& random) {
  std::uniform_int_distribution<int> coordinate(low, high);
  std::set<Place> places;
  while (places.size() < n)
    places.insert({coordinate(random), coordinate(random), coordinate(random)});
  std::vector<octomap::OcTreeKey> keys;
  for (const Place& p : places)
    keys.emplace_back(static_cast<uint16_t>(p[0]), static_cast<uint16_t>(p[1]),
                      static_cast<uint16_t>(p[2]));
  std::shuffle(keys.begin(), keys.end(), random);
  return keys;
}

void expectSameAsTwin(const std::vector<octomap::OcTreeKey>& keys,
                      const std::vector<Place>& places) {
  const VoxelIndex index(keys);
  const MapIndex twin(keys);
  for (const Place& p : places)
    ASSERT_EQ(index.find(p[0], p[1], p[2]), twin.find(p)) << p[0] << " " << p[1] << " " << p[2];
}

TEST(VoxelIndex, FindsWhatAMapFindsAmongDenseVoxels) {
  std::mt19937 random(1);
  const auto keys = randomKeys(5000, 32700, 32729, random);  // a fifth of all places
  std::vector<Place> places;
  for (int x = 32695; x < 32735; x++)
    for (int y = 32695; y < 32735; y++)
      for (int z = 32695; z < 32735; z++) places.push_back({x, y, z});
  expectSameAsTwin(keys, places);
}

TEST(VoxelIndex, FindsWhatAMapFindsAmongScatteredVoxels) {
  std::mt19937 random(2);
  const auto keys = randomKeys(5000, 0, 65535, random);  // nearly every voxel a block of its own
  std::vector<Place> places;
  for (const auto& k : keys)
    for (int d = -1; d <= 1; d++) places.push_back({k[0] + d, k[1], k[2]});
  expectSameAsTwin(keys, places);
}

TEST(VoxelIndex, CoordinatesBeyondTheKeyRangeFindNothingAndDoNotWrapAround) {
  const std::vector<octomap::OcTreeKey> corners = {{0, 0, 0}, {65535, 65535, 65535}, {0, 65535, 7}};
  std::vector<Place> places;
  for (const int x : {-65536, -70, -8, -1, 0, 65535, 65536, 65543, 131071})
    for (const int y : {-65536, -1, 0, 65535, 65536, 131071})
      for (const int z : {-65529, -1, 0, 7, 65535, 65536, 65543}) places.push_back({x, y, z});
  expectSameAsTwin(corners, places);
}

TEST(VoxelIndex, OfNoVoxelsFindsNothing) {
  const VoxelIndex index({});
  EXPECT_EQ(index.find(0, 0, 0), VoxelIndex::kNone);
  EXPECT_EQ(index.find(32768, 32768, 32768), VoxelIndex::kNone);
  EXPECT_EQ(index.find(-1, -1, -1), VoxelIndex::kNone);
}

TEST(OffsetsWithin, AreAllThoseInTheBallNearestFirst) {
  for (const double radius : {0.0, 0.9, 1.0, 1.5, 2.0, 2.5, 6.0, 7.3}) {
    const auto squared = [](const VoxelIndex::Offset& o) {
      return o[0] * o[0] + o[1] * o[1] + o[2] * o[2];
    };
    size_t expected = 0;
    for (int x = -8; x <= 8; x++)
      for (int y = -8; y <= 8; y++)
        for (int z = -8; z <= 8; z++) expected += std::sqrt(squared({x, y, z})) <= radius;

    const auto offsets = VoxelIndex::offsetsWithin(radius);
    EXPECT_EQ(offsets.size(), expected) << radius;
    EXPECT_EQ(std::set<VoxelIndex::Offset>(offsets.begin(), offsets.end()).size(), expected);
    EXPECT_EQ(offsets.front(), (VoxelIndex::Offset{0, 0, 0}));
    EXPECT_LE(squared(offsets.back()), radius * radius);
    EXPECT_TRUE(std::is_sorted(offsets.begin(), offsets.end(), [&](const auto& a, const auto& b) {
      return squared(a) < squared(b);
    })) << radius;
  }
}

}  // namespace
}  // namespace mrpt::fusion::test
