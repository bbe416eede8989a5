// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_team/ledger/ledger.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <stdexcept>
#include <string>

#include "fusion_octree/build.h"
#include "fusion_octree/resampling.h"
#include "support/test_maps.h"
#include "support/tree_tools.h"

namespace mrpt::fusion::test::ledger_test {
namespace {

using map_tests::putVoxel;
using map_tests::sameTree;
using map_tests::sceneTree;
using map_tests::sensorModelBits;
using octomap::OcTree;
using Pose = std::optional<Eigen::Isometry3d>;

constexpr MergePolicy kPolicies[] = {MergePolicy::RelativeEntropy, MergePolicy::Average,
                                     MergePolicy::Stitch, MergePolicy::Bayes};

SourceName nameOf(int robot) { return {"r" + std::to_string(robot), ""}; }

Source sourceOf(int robot, unsigned seed, uint64_t sequence = 1, double resolution = 0.1) {
  return {nameOf(robot), sequence, sceneTree(resolution, seed)};
}

Pose placeOf(int i) { return poseOf(0.7 * i, -0.4 * i, 0.1 * i, 23.0 * i, 1.0 * i); }

LedgerParams by(MergePolicy policy) {
  LedgerParams params;
  params.merge.policy = policy;
  return params;
}

/** What a run from scratch gives for the entries of a ledger, added in reverse order. */
std::shared_ptr<const OcTree> fromScratch(const Ledger& ledger, const LedgerParams& params = {}) {
  Ledger fresh(params);
  const auto entries = ledger.entries();
  for (auto e = entries.rbegin(); e != entries.rend(); ++e) fresh.add(e->source, e->pose);
  return fresh.map();
}

testing::AssertionResult sameMap(const std::shared_ptr<const OcTree>& a,
                                 const std::shared_ptr<const OcTree>& b) {
  if (!a || !b) {
    if (!a && !b) return testing::AssertionSuccess();
    return testing::AssertionFailure() << "only one of the maps is empty";
  }
  if (sensorModelBits(*a) != sensorModelBits(*b))
    return testing::AssertionFailure() << "the sensor models differ";
  return sameTree(*a, *b);
}

// ---------------------------------------------------------------- the fused map

TEST(Ledger, WithoutPlacedSourcesHasNoMap) {
  Ledger ledger;
  EXPECT_FALSE(ledger.map());
  ledger.add(sourceOf(1, 1), std::nullopt);
  EXPECT_FALSE(ledger.map());
  EXPECT_EQ(ledger.entries().size(), 1U);
  ledger.move(nameOf(1), kIdentity);
  EXPECT_TRUE(ledger.map());
  ledger.remove(nameOf(1));
  EXPECT_FALSE(ledger.map());
}

TEST(Ledger, OneSourceKeepsItsVoxels) {
  const Source source = sourceOf(1, 1);
  Ledger ledger;
  ledger.add(source, kIdentity);
  EXPECT_TRUE(map_tests::sameVoxels(map_tests::voxelsOf(*ledger.map()),
                                    map_tests::voxelsOf(*source.map())));
}

TEST(Ledger, TwoSourcesAreMergedAsByMergeMaps) {
  for (const MergePolicy policy : kPolicies)
    for (const Eigen::Isometry3d& T : {kIdentity, *placeOf(1)})
      for (const double resolution : {0.1, 0.06}) {
        const Source a = sourceOf(1, 1), b = sourceOf(2, 2, 1, resolution);
        Ledger ledger(by(policy));
        ledger.add(b, T);
        ledger.add(a, kIdentity);
        const std::shared_ptr<const OcTree> merged =
            mergeMaps(*a.map(), *b.map(), T, by(policy).merge);
        EXPECT_TRUE(sameMap(ledger.map(), merged)) << static_cast<int>(policy);
      }
}

TEST(Ledger, CombinesManySourcesInTheOrderOfTheirNames) {
  // A column of voxels: one known in all maps, and one for each pair. No resampling.
  const float values[] = {0.3F, -1.1F, 2.0F, 3.1F};
  for (const MergePolicy policy : kPolicies) {
    Ledger ledger(by(policy));
    for (const int robot : {3, 0, 2, 1}) {
      auto map = std::make_unique<OcTree>(0.1);
      putVoxel(*map, {0, 0, 0}, values[robot]);
      putVoxel(*map, {40, robot / 2, 0}, values[robot]);
      map_tests::finish(*map);
      ledger.add(Source(nameOf(robot), 1, std::move(map)), kIdentity);
    }
    const auto fuse = [&](float a, float b) {
      const OcTree model(0.1);
      return fuseLogOdds(a, b, by(policy).merge, model.getClampingThresMinLog(),
                         model.getClampingThresMaxLog());
    };
    const auto fused = map_tests::voxelsOf(*ledger.map());
    EXPECT_EQ(fused.at({40, 0, 0}), fuse(values[0], values[1]));
    EXPECT_EQ(fused.at({40, 1, 0}), fuse(values[2], values[3]));
    const float folded = fuse(fuse(fuse(values[0], values[1]), values[2]), values[3]);
    if (policy == MergePolicy::Bayes)
      EXPECT_EQ(fused.at({0, 0, 0}), OcTree(0.1).getClampingThresMaxLog());
    else
      EXPECT_EQ(fused.at({0, 0, 0}), folded);
  }
}

TEST(Ledger, BayesClampsOnceAtTheEnd) {
  Ledger ledger;
  const float values[] = {3.0F, 3.0F, -3.0F};  // 3 + 3 is above the upper threshold
  for (int robot = 0; robot < 3; robot++) {
    auto map = std::make_unique<OcTree>(0.1);
    putVoxel(*map, {0, 0, 0}, values[robot]);
    putVoxel(*map, {9, robot, 0}, 1.F);  // so that no two maps are equal
    ledger.add(Source(nameOf(robot), 1, std::move(map)), kIdentity);
  }
  EXPECT_EQ(map_tests::voxelsOf(*ledger.map()).at({0, 0, 0}), 3.0F);
}

TEST(Ledger, TheReferenceComesFirst) {
  LedgerParams params;
  params.merge.policy = MergePolicy::Stitch;
  params.reference = nameOf(7);
  const Source a = sourceOf(1, 1), b = sourceOf(7, 2, 1, 0.2);
  Ledger ledger(params);
  ledger.add(a, placeOf(1));
  EXPECT_EQ(ledger.map()->getResolution(), 0.1);
  ledger.add(b, kIdentity);
  const std::shared_ptr<const OcTree> merged =
      mergeMaps(*b.map(), *a.map(), *placeOf(1), params.merge);
  EXPECT_TRUE(sameMap(ledger.map(), merged));
  ledger.remove(nameOf(7));
  EXPECT_TRUE(sameMap(ledger.map(), fromScratch(ledger, params)));
}

TEST(Ledger, AMapThatWasReturnedDoesNotChange) {
  Ledger ledger;
  ledger.add(sourceOf(1, 1), kIdentity);
  const auto before = ledger.map();
  const OcTree copy(*before);
  EXPECT_EQ(ledger.map(), before);  // nothing changed
  ledger.add(sourceOf(2, 2), placeOf(1));
  EXPECT_NE(ledger.map(), before);
  EXPECT_TRUE(sameTree(copy, *before));
}

// ---------------------------------------------------------------- what is a source

TEST(Ledger, SaysWhatAnAdditionDid) {
  Ledger ledger;
  EXPECT_EQ(ledger.add(sourceOf(1, 1, 2), kIdentity), AddResult::Added);
  EXPECT_EQ(ledger.add(sourceOf(1, 1, 2), placeOf(3)), AddResult::Duplicate);
  EXPECT_EQ(ledger.add(sourceOf(1, 2, 1), kIdentity), AddResult::Older);
  EXPECT_EQ(ledger.add(sourceOf(1, 3, 5), kIdentity), AddResult::Replaced);
  EXPECT_EQ(ledger.add(sourceOf(2, 3, 1), kIdentity), AddResult::SameContent);
  EXPECT_EQ(ledger.entries().size(), 2U);
}

TEST(Ledger, OfTwoMapsOfOneSequenceTheOrderOfArrivalDoesNotDecide) {
  Ledger one, other;
  one.add(sourceOf(1, 1), kIdentity);
  one.add(sourceOf(1, 2), kIdentity);
  other.add(sourceOf(1, 2), kIdentity);
  other.add(sourceOf(1, 1), kIdentity);
  EXPECT_TRUE(sameMap(one.map(), other.map()));
}

TEST(Ledger, CountsEqualMapsOnceInAnyOrder) {
  Ledger alone, ledger, reversed;
  alone.add(sourceOf(1, 1), placeOf(1));
  ledger.add(sourceOf(1, 1), placeOf(1));
  ledger.add(sourceOf(2, 1), placeOf(2));
  reversed.add(sourceOf(2, 1), placeOf(2));
  reversed.map();
  reversed.add(sourceOf(1, 1), placeOf(1));
  EXPECT_TRUE(sameMap(ledger.map(), alone.map()));
  EXPECT_TRUE(sameMap(reversed.map(), alone.map()));
  EXPECT_TRUE(ledger.entries()[0].counts());
  EXPECT_FALSE(ledger.entries()[1].counts());
  // The copy counts as soon as the first is gone.
  ledger.remove(nameOf(1));
  EXPECT_TRUE(ledger.entries()[0].counts());
  EXPECT_TRUE(sameMap(ledger.map(), fromScratch(ledger)));
}

TEST(Ledger, CountsEqualMapsTwiceIfTheyAreIndependent) {
  LedgerParams params;
  params.independent = true;
  const Source a = sourceOf(1, 1), b = sourceOf(2, 1);
  Ledger ledger(params);
  ledger.add(a, kIdentity);
  EXPECT_EQ(ledger.add(b, kIdentity), AddResult::Added);
  const std::shared_ptr<const OcTree> merged = mergeMaps(*a.map(), *b.map(), kIdentity, {});
  EXPECT_TRUE(sameMap(ledger.map(), merged));
}

TEST(Ledger, WhatWasRemovedDoesNotComeBackLate) {
  Ledger ledger;
  EXPECT_FALSE(ledger.remove(nameOf(1)));
  ledger.add(sourceOf(1, 1, 4), kIdentity);
  EXPECT_TRUE(ledger.remove(nameOf(1)));
  EXPECT_EQ(ledger.add(sourceOf(1, 1, 4), kIdentity), AddResult::Older);
  EXPECT_EQ(ledger.add(sourceOf(1, 2, 5), kIdentity), AddResult::Added);
  // A removal that arrives before or after what it removes.
  EXPECT_FALSE(ledger.remove(nameOf(2), 3));
  EXPECT_EQ(ledger.add(sourceOf(2, 2, 3), kIdentity), AddResult::Older);
  EXPECT_FALSE(ledger.remove(nameOf(1), 4));
  EXPECT_EQ(ledger.entries().size(), 1U);
}

TEST(Ledger, RefusesPosesThatAreNotFinite) {
  Ledger ledger;
  Eigen::Isometry3d bad = kIdentity;
  bad.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ledger.add(sourceOf(1, 1), bad), std::invalid_argument);
  EXPECT_TRUE(ledger.entries().empty());
  ledger.add(sourceOf(1, 1), kIdentity);
  EXPECT_THROW(ledger.move(nameOf(1), bad), std::invalid_argument);
  EXPECT_THROW(Source(nameOf(1), 1, nullptr), std::invalid_argument);
}

TEST(Ledger, NamesTheSourceThatDoesNotFitAndGoesOnWithoutIt) {
  Ledger ledger;
  ledger.add(sourceOf(1, 1), kIdentity);
  const auto before = ledger.map();
  ledger.add(sourceOf(2, 2), poseOf(1e6, 0, 0, 0));
  try {
    ledger.map();
    ADD_FAILURE() << "the map fits";
  } catch (const std::exception& e) {
    EXPECT_EQ(std::string(e.what()).rfind("r2: ", 0), 0U) << e.what();
  }
  ledger.remove(nameOf(2));
  EXPECT_TRUE(sameMap(ledger.map(), before));
}

// ---------------------------------------------------------------- any history, the same map

/** Performs random steps, with a brute-force model of what the ledger should hold. */
class History {
 public:
  History(unsigned seed, const LedgerParams& params) : random_(seed), ledger(params) {}

  void step() {
    const int robot = pick(6);
    const SourceName name = nameOf(robot);
    switch (pick(6)) {
      case 0:
      case 1:
        return add(robot);
      case 2:  // a duplicate or a late message
        if (!sent_.empty())
          deliver(sent_[static_cast<size_t>(pick(static_cast<int>(sent_.size())))]);
        return;
      case 3:
        if (pick(2) && held.count(name)) {
          removed_[name] = std::max(removed_[name], held.at(name).first.sequence());
          held.erase(name);
          ledger.remove(name);
        }
        return;
      default: {
        const Pose pose = pick(4) ? placeOf(pick(7)) : pick(2) ? Pose(kIdentity) : std::nullopt;
        if (held.count(name)) held.at(name).second = pose;
        ledger.move(name, pose);
      }
    }
  }

 private:
  using Held = std::pair<Source, Pose>;

  int pick(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }

  void add(int robot) {
    // Few maps, so that some robots send the same map. Few robots have coarser voxels.
    const auto sequence = static_cast<uint64_t>(1 + pick(40));
    sent_.push_back(
        {sourceOf(robot, static_cast<unsigned>(pick(5)), sequence, robot == 0 ? 0.2 : 0.1),
         pick(5) ? placeOf(pick(7)) : Pose()});
    deliver(sent_.back());
  }

  void deliver(const Held& message) {
    const auto& [source, pose] = message;
    ledger.add(source, pose);
    const auto removed = removed_.find(source.name());
    if (removed != removed_.end() && source.sequence() <= removed->second) return;
    const auto rank = [](const Source& s) { return std::pair(s.sequence(), s.contentHash()); };
    const auto old = held.find(source.name());
    if (old != held.end() && rank(source) <= rank(old->second.first)) return;
    held.erase(source.name());
    held.emplace(source.name(), message);
  }

  std::mt19937 random_;
  std::vector<Held> sent_;
  std::map<SourceName, uint64_t> removed_;

 public:
  Ledger ledger;
  std::map<SourceName, Held> held;
};

void expectSameAsFromScratchAfterEachStep(unsigned seed, int steps, const LedgerParams& params) {
  History history(seed, params);
  for (int i = 0; i < steps; i++) {
    history.step();
    if (i % 3 == 1) continue;  // several changes at once
    Ledger fresh(params);
    for (auto h = history.held.rbegin(); h != history.held.rend(); ++h)
      fresh.add(h->second.first, h->second.second);
    ASSERT_TRUE(sameMap(history.ledger.map(), fresh.map())) << "step " << i;
  }
}

TEST(Ledger, AnyHistoryOf500StepsGivesTheMapFromScratch) {
  expectSameAsFromScratchAfterEachStep(1, 500, {});
}

TEST(Ledger, AnyHistoryGivesTheMapFromScratchWithAllPoliciesAndSettings) {
  unsigned seed = 2;
  for (const MergePolicy policy : kPolicies)
    for (const bool independent : {false, true}) {
      LedgerParams params = by(policy);
      params.independent = independent;
      if (independent) params.reference = nameOf(3);
      expectSameAsFromScratchAfterEachStep(seed++, 25, params);
    }
}

TEST(Ledger, PrunedZerosOfBothSignsStayAsFromScratch) {
  // Eight blocks of zeros are one leaf of the fused map, although one block has negative zeros.
  const auto zeros = [](float of_last) {
    auto map = std::make_unique<OcTree>(0.1);
    for (int i = 0; i < 8; i++)
      map_tests::putLeaf(*map, {16 * (i & 1), 16 * (i >> 1 & 1), 16 * (i >> 2)}, 12,
                         i == 7 ? of_last : 0.F);
    return map;
  };
  auto far = std::make_unique<OcTree>(0.1);
  putVoxel(*far, {3, 3, 3}, 1.F);
  Ledger ledger;
  ledger.add(Source(nameOf(1), 1, zeros(-0.F)), kIdentity);
  ledger.map();
  ledger.add(Source(nameOf(2), 1, std::move(far)), kIdentity);
  EXPECT_TRUE(sameMap(ledger.map(), fromScratch(ledger)));
}

TEST(Ledger, DoesNotDependOnTheNumberOfThreads) {
  const auto run = [] {
    Ledger ledger;
    for (int i = 0; i < 5; i++) ledger.add(sourceOf(i, static_cast<unsigned>(i)), placeOf(i));
    ledger.map();
    ledger.move(nameOf(3), placeOf(6));
    return ledger.map();
  };
  EXPECT_TRUE(sameMap(withThreads(1, run), withThreads(4, run)));
}

}  // namespace
}  // namespace mrpt::fusion::test::ledger_test
