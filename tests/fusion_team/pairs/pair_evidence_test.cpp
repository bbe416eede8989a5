// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the evidence of pairs, on rooms of free space with walls and a post. */
#include "fusion_team/pairs/pair_evidence.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "fusion_team/pairs/pair_matches.h"

namespace mrpt::fusion::test::pair_evidence_test {
namespace {

constexpr double kVoxel = 0.1;

/** A room of 6 x 5 x 2.5 m. A post stands \a aside metres beside its place. */
PreparedMap room(double aside) {
  auto map = std::make_shared<octomap::OcTree>(kVoxel);
  const double post = 2.05 + aside;
  for (int x = 0; x < 60; x++)
    for (int y = 0; y < 50; y++)
      for (int z = 0; z < 25; z++) {
        const double px = kVoxel * (x + 0.5), py = kVoxel * (y + 0.5);
        const bool is_wall = x == 0 || x == 59 || y == 0 || y == 49 || z == 0 || z == 24;
        const bool is_post = std::abs(px - post) < 0.2 && std::abs(py - 2.55) < 0.2;
        map->updateNode(octomap::point3d(float(px), float(py), float(kVoxel * (z + 0.5))),
                        is_wall || is_post, true);
      }
  map->updateInnerOccupancy();
  return PreparedMap(std::shared_ptr<const octomap::OcTree>(map));
}

PairEvidence evidenceOf(const PreparedMap& a, const PreparedMap& b,
                        const Eigen::Isometry3d& T = Eigen::Isometry3d::Identity()) {
  EvidenceOfPair pair(a, b, Options());
  return pair.near(T);
}

TEST(PairEvidence, EqualMapsConfirmEachOther) {
  const PairEvidence e = evidenceOf(room(0), room(0));
  EXPECT_GT(countOf(e.of_a.confirmed), 100);
  EXPECT_EQ(e.displaced(), 0);
  EXPECT_EQ(e.contradicted(), 0);
}

TEST(PairEvidence, ANearObstacleIsDisplacedAndAFarObstacleIsContradicted) {
  const PairEvidence drifted = evidenceOf(room(0), room(0.4));
  EXPECT_GT(drifted.displaced(), 0);
  EXPECT_EQ(drifted.contradicted(), 0);
  const PairEvidence moved = evidenceOf(room(0), room(1.6));
  EXPECT_GT(moved.contradicted(), 0);
}

TEST(PairEvidence, MapsThatDoNotMeetSayNothing) {
  Eigen::Isometry3d far = Eigen::Isometry3d::Identity();
  far.translation().x() = 50;
  const PairEvidence e = evidenceOf(room(0), room(0), far);
  EXPECT_TRUE(e.of_a.confirmed.empty());
  EXPECT_TRUE(e.of_b.confirmed.empty());
}

/** The tolerance of a team of two rooms that are matched at the right pose. */
ConflictTolerance adapted(const PreparedMap& a, const PreparedMap& b, bool accepted,
                          double runner_up, double support = 1) {
  const std::vector<RobotMap> maps{{"a", a}, {"b", b}};
  PairMemory memory;
  EvidenceOfMaps evidence(maps, Options(), memory);
  PairMatch match{0, 1, {}};
  match.alignment.evaluation.accepted = accepted;
  match.alignment.evaluation.runner_up = runner_up;
  match.alignment.evaluation.rival_weight = runner_up * support;
  evidence.adaptTolerance({match});
  return evidence.tolerance();
}

TEST(ConflictTolerance, GrowsWithWhatMovedBetweenTheMapsOfAClearMatch) {
  const ConflictTolerance still = adapted(room(0), room(0), true, 0.1);
  const ConflictTolerance moved = adapted(room(0), room(1.6), true, 0.1);
  EXPECT_GT(moved.contradicted, 1.5 * still.contradicted);
  EXPECT_EQ(adapted(room(0), room(1.6), false, 0.1).contradicted, still.contradicted)
      << "a match that is not accepted may be wrong";
  EXPECT_EQ(adapted(room(0), room(1.6), true, 0.8).contradicted, still.contradicted)
      << "a match with a strong rival may be wrong";
  EXPECT_EQ(adapted(room(0), room(1.6), true, 0.8, 0.1).contradicted, moved.contradicted)
      << "a rival that confirms next to nothing is not strong";
}

}  // namespace
}  // namespace mrpt::fusion::test::pair_evidence_test
