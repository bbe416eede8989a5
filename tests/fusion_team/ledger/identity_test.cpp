// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of which maps have the same observations, and of fused maps that count them once. */
#include "fusion_team/ledger/identity.h"

#include <gtest/gtest.h>
#include <mrpt/fusion/many_maps.h>

#include "fusion_octree/resampling.h"
#include "fusion_octree/voxel_hash.h"
#include "fusion_team/ledger/ledger.h"
#include "support/test_maps.h"
#include "support/tree_tools.h"

namespace mrpt::fusion::test::identity_test {
namespace {

using map_tests::sameTree;
using map_tests::sceneTree;
using octomap::OcTree;

const Eigen::Isometry3d kHere = Eigen::Isometry3d::Identity();

SourceId file(uint64_t hash) { return {{}, {}, 0, hash}; }
SourceId sent(const std::string& robot, uint64_t sequence, uint64_t hash) {
  return {robot, {}, sequence, hash};
}

std::vector<Counting> countingOf(const std::vector<Sources>& maps) {
  std::vector<const Sources*> pointers;
  for (const Sources& s : maps) pointers.push_back(&s);
  std::vector<Counting> counting;
  for (const Share& share : sharesOf(pointers)) counting.push_back(share.counting);
  return counting;
}

using C = Counting;

TEST(Identity, MapsWithOtherVoxelsAllCount) {
  EXPECT_EQ(countingOf({{file(1)}, {file(2)}, {sent("a", 0, 3)}, {sent("b", 0, 4)}}),
            (std::vector<C>{C::All, C::All, C::All, C::All}));
}

TEST(Identity, OfCopiesTheFirstCounts) {
  EXPECT_EQ(countingOf({{file(1)}, {file(2)}, {file(1)}, {sent("a", 0, 1)}}),
            (std::vector<C>{C::All, C::All, C::Copy, C::Copy}));
}

TEST(Identity, AFusedMapHoldsItsSources) {
  EXPECT_EQ(countingOf({{file(1), file(2)}, {file(2)}, {file(3)}}),
            (std::vector<C>{C::All, C::None, C::All}));
  EXPECT_EQ(countingOf({{file(2)}, {file(1), file(2)}}), (std::vector<C>{C::None, C::All}));
  EXPECT_EQ(countingOf({{file(1), file(2)}, {file(2), file(1)}}),
            (std::vector<C>{C::All, C::None}));
}

TEST(Identity, FusedMapsWithACommonSourceFillUnknownSpace) {
  EXPECT_EQ(countingOf({{file(1), file(2)}, {file(2), file(3)}}),
            (std::vector<C>{C::All, C::UnknownSpace}));
  EXPECT_EQ(countingOf({{file(1), file(2)}, {file(2), file(3), file(4)}}),
            (std::vector<C>{C::UnknownSpace, C::All}));
}

TEST(Identity, ALaterMapOfARobotHoldsTheEarlierMap) {
  EXPECT_EQ(countingOf({{sent("a", 1, 1)}, {sent("a", 2, 2)}}), (std::vector<C>{C::None, C::All}));
  // The fused map has an older version: what is new is not known, so unknown space is filled.
  EXPECT_EQ(countingOf({{sent("a", 1, 1), file(3)}, {sent("a", 2, 2)}}),
            (std::vector<C>{C::All, C::UnknownSpace}));
  EXPECT_EQ(countingOf({{sent("a", 1, 1)}, {sent("b", 2, 2)}}), (std::vector<C>{C::All, C::All}));
}

TEST(Identity, SaysWithWhichMap) {
  const Sources a{file(1), file(2)}, b{file(2)};
  const auto shares = sharesOf({&a, &b});
  EXPECT_FALSE(shares[0].with);
  EXPECT_EQ(shares[1].with, 0U);
}

TEST(Identity, ASourceIsInASetOnce) {
  Sources all{file(1)};
  addSources({file(1), file(2)}, all);
  EXPECT_EQ(all, (Sources{file(1), file(2)}));
  addSources({sent("a", 3, 1), sent("b", 4, 1)}, all);
  EXPECT_EQ(all, (Sources{sent("a", 3, 1), file(2), sent("b", 4, 1)})) << "the robot is known now";
  addSources({file(1), sent("a", 5, 1), sent("a", 2, 1)}, all);
  EXPECT_EQ(all, (Sources{sent("a", 5, 1), file(2), sent("b", 4, 1)}));
}

// ---------------------------------------------------------------- merged maps

struct Scenes {
  const std::unique_ptr<OcTree> a = sceneTree(0.1, 1), b = sceneTree(0.1, 2), c = sceneTree(0.1, 3);
  MergedSources merged(const OcTree& m, const OcTree& n, bool independent = false) const {
    MergeParams params;
    params.independent = independent;
    return mergeSources({m}, {n}, kHere, params);
  }
};

TEST(MergeSources, WithoutACommonSourceIsMergeMaps) {
  const Scenes s;
  const MergedSources ab = s.merged(*s.a, *s.b);
  EXPECT_TRUE(sameTree(*ab.map, *mergeMaps(*s.a, *s.b, kHere, {})));
  EXPECT_EQ(ab.of_a, C::All);
  EXPECT_EQ(ab.of_b, C::All);
  ASSERT_EQ(ab.sources.size(), 2U);
  EXPECT_EQ(ab.sources[1].content_hash, voxelHash(*s.b));
}

TEST(MergeSources, CountsAMapAndItsCopyOnce) {
  const Scenes s;
  const MergedSources aa = s.merged(*s.a, *s.a);
  EXPECT_TRUE(sameTree(*aa.map, *s.a));
  EXPECT_EQ(aa.of_b, C::Copy);
  EXPECT_EQ(aa.sources.size(), 1U);
  const MergedSources twice = s.merged(*s.a, *s.a, true);
  EXPECT_TRUE(sameTree(*twice.map, *mergeMaps(*s.a, *s.a, kHere, {})));
  EXPECT_FALSE(sameTree(*twice.map, *s.a));
}

TEST(MergeSources, AtAGivenPoseACopyIsTheSameSourceWhereItIsOnly) {
  const Scenes s;
  Eigen::Isometry3d near = kHere, far = kHere;
  near.translation().x() = 0.01;
  far.translation().x() = 3;
  const auto at = [&](const Eigen::Isometry3d& T, bool is_given) {
    return mergeSources({*s.a}, {*s.a}, T, {}, is_given);
  };
  EXPECT_TRUE(sameTree(*at(near, true).map, *s.a));
  EXPECT_TRUE(sameTree(*at(far, true).map, *mergeMaps(*s.a, *s.a, far, {})));
  EXPECT_TRUE(sameTree(*at(far, false).map, *s.a)) << "a match: one source has one place";
}

TEST(MergeSources, AFusedMapAndOneOfItsSourcesAreTheFusedMap) {
  const Scenes s;
  const MergedSources ab = s.merged(*s.a, *s.b);
  const SourcedMap fused{*ab.map, ab.sources};
  const MergedSources with_b = mergeSources(fused, {*s.b}, kHere, {});
  EXPECT_TRUE(sameTree(*with_b.map, *ab.map));
  EXPECT_EQ(with_b.of_b, C::None);
  EXPECT_EQ(with_b.sources, ab.sources);
  const MergedSources of_b = mergeSources({*s.b}, fused, kHere, {});
  EXPECT_EQ(of_b.of_a, C::None);
  EXPECT_TRUE(sameTree(*of_b.map, *ab.map));
  // A new map is added, once.
  const MergedSources abc = mergeSources(fused, {*s.c}, kHere, {});
  EXPECT_TRUE(sameTree(*abc.map, *mergeMaps(*ab.map, *s.c, kHere, {})));
  EXPECT_TRUE(sameTree(*mergeSources({*abc.map, abc.sources}, {*s.c}, kHere, {}).map, *abc.map));
}

TEST(MergeSources, FusedMapsWithACommonSourceAddOnlyUnknownSpace) {
  const Scenes s;
  const MergedSources ab = s.merged(*s.a, *s.b), bc = s.merged(*s.b, *s.c);
  const MergedSources all = mergeSources({*ab.map, ab.sources}, {*bc.map, bc.sources}, kHere, {});
  EXPECT_EQ(all.of_b, C::UnknownSpace);
  EXPECT_EQ(all.sources.size(), 3U);
  MergeParams stitch;
  stitch.policy = MergePolicy::Stitch;
  EXPECT_TRUE(sameTree(*all.map, *mergeMaps(*ab.map, *bc.map, kHere, stitch)));
}

// ---------------------------------------------------------------- the ledger

TEST(Ledger, AnyHistoryOfFusedMapsGivesTheMapFromScratch) {
  const Scenes s;
  const MergedSources ab = s.merged(*s.a, *s.b), bc = s.merged(*s.b, *s.c);
  const std::shared_ptr<const OcTree> map_ab(new OcTree(*ab.map)), map_bc(new OcTree(*bc.map)),
      map_a(new OcTree(*s.a)), map_c(new OcTree(*s.c));
  Eigen::Isometry3d moved = kHere;
  moved.translation() = Eigen::Vector3d(0.3, -0.2, 0);
  uint64_t sequence = 0;
  const auto source = [&](int i) {
    sequence++;
    if (i == 0) return Source({"ab", {}}, sequence, map_ab, ab.sources);
    if (i == 1) return Source({"bc", {}}, sequence, map_bc, bc.sources);
    if (i == 2) return Source({"a", {}}, sequence, map_a);
    return Source({"c", {}}, sequence, map_c);
  };
  Ledger ledger;
  std::mt19937 random(5);
  for (int step = 0; step < 60; step++) {
    const Source chosen = source(static_cast<int>(random() % 4));
    const auto pose = random() % 4 ? std::optional(random() % 2 ? moved : kHere) : std::nullopt;
    if (random() % 3)
      ledger.add(chosen, pose);
    else if (random() % 2)
      ledger.move(chosen.name(), pose);
    else
      ledger.remove(chosen.name());
    Ledger fresh;
    const auto entries = ledger.entries();
    for (auto e = entries.rbegin(); e != entries.rend(); ++e) fresh.add(e->source, e->pose);
    const auto map = ledger.map(), expected = fresh.map();
    ASSERT_EQ(map == nullptr, expected == nullptr) << step;
    if (map) {
      ASSERT_TRUE(sameTree(*map, *expected)) << step;
    }
  }
}

}  // namespace
}  // namespace mrpt::fusion::test::identity_test
