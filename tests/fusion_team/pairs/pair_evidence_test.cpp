// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the evidence of pairs, on rooms of free space with walls and a post. */
#include "fusion_team/pairs/pair_evidence.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
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

TEST(PairEvidence, PosesAtOnePlaceShareTheRegisteredPose) {
  const PreparedMap a = room(0), b = room(0);
  EvidenceOfPair pair(a, b, Options());
  Eigen::Isometry3d beside = Eigen::Isometry3d::Identity();
  beside.translation() = Eigen::Vector3d(0.2, 0.15, 0);
  const auto first = pair.near(Eigen::Isometry3d::Identity()).registered;
  const auto other = pair.near(beside).registered;
  ASSERT_TRUE(first && other);
  EXPECT_TRUE(first->isApprox(*other, 0));
  EXPECT_LT(first->translation().norm(), 0.05);
  EXPECT_LT(pair.covarianceAt(*first).trace(), 0.1);
}

TEST(PairEvidence, MapsThatShareLittleFixNoPose) {
  Eigen::Isometry3d apart = Eigen::Isometry3d::Identity();
  apart.translation().x() = 5.8;  // the rooms share the end of the floor
  const PairEvidence e = evidenceOf(room(0), room(0), apart);
  EXPECT_FALSE(e.of_a.confirmed.empty()) << "the boxes meet";
  EXPECT_FALSE(e.registered);
}

TEST(PairEvidence, MapsThatDoNotMeetSayNothing) {
  Eigen::Isometry3d far = Eigen::Isometry3d::Identity();
  far.translation().x() = 50;
  const PairEvidence e = evidenceOf(room(0), room(0), far);
  EXPECT_TRUE(e.of_a.confirmed.empty());
  EXPECT_TRUE(e.of_b.confirmed.empty());
}

/** B is turned about the middle of a room: walls lie on walls. */
Eigen::Isometry3d turned() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(6, 5, 0);
  T.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()).matrix();
  return T;
}

/** B stands beside A: their walls touch. */
Eigen::Isometry3d beside() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation().x() = 5.9;
  return T;
}

/** B stands half in the room of A. */
Eigen::Isometry3d askew() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(2.3, 1.7, 0);
  T.linear() = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()).matrix();
  return T;
}

/** A match of rooms \a a and \a b that claims to be sure of its first hypothesis. */
PairMatch claimed(const std::vector<Eigen::Isometry3d>& poses, size_t a = 0, size_t b = 1) {
  PairMatch match{a, b, {}};
  match.alignment.evaluation.accepted = true;
  match.alignment.evaluation.probability = 1;
  match.alignment.match.T_a_b = poses.front();
  for (const Eigen::Isometry3d& T : poses)
    match.alignment.match.hypotheses.push_back({T, 1, Matrix6d::Identity()});
  return match;
}

/** The tolerance for each room of a team whose rooms are matched. */
std::vector<ConflictTolerance> adapted(const std::vector<PreparedMap>& rooms,
                                       const std::vector<PairMatch>& matches) {
  std::vector<RobotMap> maps;
  for (const PreparedMap& map : rooms) maps.push_back({std::to_string(maps.size()), map});
  PairMemory memory;
  EvidenceOfMaps evidence(maps, Options(), memory);
  evidence.adaptTolerance(matches);
  std::vector<ConflictTolerance> tolerance;
  for (size_t k = 0; k < maps.size(); k++) tolerance.push_back(evidence.tolerance(k));
  return tolerance;
}

const Eigen::Isometry3d kRight = Eigen::Isometry3d::Identity();

TEST(ConflictTolerance, GrowsWithWhatMovedBetweenMapsWithAClearPose) {
  const double still = adapted({room(0), room(0)}, {claimed({kRight})})[0].contradicted;
  const double moved = adapted({room(0), room(1.6)}, {claimed({kRight})})[0].contradicted;
  EXPECT_GT(moved, 1.5 * still);
  EXPECT_EQ(adapted({room(0), room(1.6)}, {claimed({kRight, turned()})})[0].contradicted, still)
      << "a pose with a strong rival may be wrong";
  EXPECT_EQ(adapted({room(0), room(1.6)}, {claimed({kRight, beside()})})[0].contradicted, moved)
      << "a rival that confirms next to nothing is not strong";
}

TEST(ConflictTolerance, FollowsTheMapsAndNotTheClaimsOfTheirMatch) {
  const double moved = adapted({room(0), room(1.6)}, {claimed({kRight})})[0].contradicted;
  EXPECT_EQ(adapted({room(0), room(1.6)}, {claimed({askew(), kRight})})[0].contradicted, moved);
  PairMatch unsure = claimed({kRight});
  unsure.alignment.evaluation.accepted = false;
  EXPECT_EQ(adapted({room(0), room(1.6)}, {unsure})[0].contradicted, moved);
}

TEST(ConflictTolerance, IsThatOfThePlaceOfAMap) {
  const std::vector<PreparedMap> rooms{room(0), room(1.6), room(0), room(0)};
  const auto tolerance = adapted(rooms, {claimed({kRight}, 0, 1), claimed({kRight}, 2, 3)});
  EXPECT_EQ(tolerance[0].contradicted, tolerance[1].contradicted);
  EXPECT_GT(tolerance[1].contradicted, 1.5 * tolerance[2].contradicted)
      << "nothing moved between rooms 2 and 3";
}

TEST(SureMatches, AreThoseThatTheMapsBearOut) {
  const std::vector<RobotMap> maps{{"a", room(0)}, {"b", room(0)}};
  PairMemory memory;
  EvidenceOfMaps evidence(maps, Options(), memory);
  EXPECT_TRUE(evidence.holds(claimed({kRight, beside()})));
  EXPECT_FALSE(evidence.holds(claimed({askew()}))) << "the maps contradict each other there";
  EXPECT_FALSE(evidence.holds(claimed({beside(), kRight}))) << "the maps fit better elsewhere";
  evidence.setSureMatches({claimed({beside(), kRight})}, 0.9);
  EXPECT_FALSE(evidence.isSure(0, 1, beside()));
  EXPECT_TRUE(evidence.isSure(0, 1, kRight)) << "the clear pose of the maps";
  EXPECT_FALSE(evidence.sureMatch(0, 1)) << "the match does not say so";
  evidence.setSureMatches({claimed({kRight, beside()})}, 0.9);
  EXPECT_TRUE(evidence.isSure(0, 1, kRight));
  ASSERT_TRUE(evidence.sureMatch(0, 1));
  EXPECT_TRUE(evidence.sureMatch(0, 1)->isApprox(kRight));
}

/** A match of rooms \a a and \a b that is not accepted. Turned rooms fit as well. */
PairMatch doubtful(size_t a, size_t b) {
  PairMatch match = claimed({kRight, turned()}, a, b);
  match.alignment.evaluation.accepted = false;
  return match;
}

TEST(SureMatches, TwoThatAgreeExplainThePoseOfAnotherPair) {
  const std::vector<RobotMap> maps{{"a", room(0)}, {"b", room(0)}, {"c", room(0)}, {"d", room(0)}};
  PairMemory memory;
  EvidenceOfMaps evidence(maps, Options(), memory);
  std::vector<PairMatch> matches{doubtful(0, 1), doubtful(1, 3), claimed({kRight}, 0, 2),
                                 claimed({kRight}, 1, 2), claimed({kRight}, 0, 3)};
  evidence.setSureMatches(matches, 0.9);
  EXPECT_FALSE(evidence.isSure(0, 1, kRight)) << "map c alone places the maps so";
  matches[1] = claimed({kRight}, 1, 3);
  evidence.setSureMatches(matches, 0.9);
  EXPECT_TRUE(evidence.isSure(0, 1, kRight)) << "maps c and d place the maps so";
  EXPECT_FALSE(evidence.isSure(0, 1, turned()));
  EXPECT_FALSE(evidence.sureMatch(0, 1)) << "the match does not say so";
  matches[1] = claimed({turned()}, 1, 3);
  evidence.setSureMatches(matches, 0.9);
  EXPECT_FALSE(evidence.isSure(0, 1, kRight)) << "maps c and d disagree";
}

TEST(SureMatches, ThatDisagreeExplainWhatMostOfThemSayInAnyOrder) {
  // Maps a and b, and maps that place b beside a: some as they are, some turned.
  const auto explained = [](const std::vector<bool>& are_turned) {
    std::vector<RobotMap> maps{{"a", room(0)}, {"b", room(0)}};
    std::vector<PairMatch> matches;
    for (size_t i = 0; i < are_turned.size(); i++) {
      maps.push_back({std::string(1, static_cast<char>('c' + i)), room(0)});
      matches.push_back(claimed({kRight}, 0, i + 2));
      matches.push_back(claimed({are_turned[i] ? turned() : kRight}, 1, i + 2));
    }
    PairMemory memory;
    EvidenceOfMaps evidence(maps, Options(), memory);
    evidence.setSureMatches(matches, 0.9);
    return std::make_pair(evidence.isSure(0, 1, kRight), evidence.isSure(0, 1, turned()));
  };
  EXPECT_EQ(explained({false, true, true, false, false}), std::make_pair(true, false));
  EXPECT_EQ(explained({true, true, false, false, false}), std::make_pair(true, false));
  EXPECT_EQ(explained({true, false, true, false, true}), std::make_pair(false, true));
  EXPECT_EQ(explained({false, true, true, false}), std::make_pair(false, false));
}

TEST(SureMatches, AClearPoseHasNoMoreConflictsThanTheLimit) {
  const std::vector<RobotMap> maps{{"a", room(0)}, {"b", room(1.6)}};
  const auto is_sure = [&](double max_conflict) {
    Options options;
    options.evaluation.max_free_conflict = max_conflict;
    PairMemory memory;
    EvidenceOfMaps evidence(maps, options, memory);
    PairMatch match = claimed({kRight});
    EXPECT_TRUE(evidence.holds(match)) << "the verdict has judged the conflicts";
    match.alignment.evaluation.accepted = false;
    evidence.setSureMatches({match}, 0.9);
    return evidence.isSure(0, 1, kRight);
  };
  EXPECT_TRUE(is_sure(Options().evaluation.max_free_conflict));
  EXPECT_FALSE(is_sure(0.001)) << "things have moved";
}

}  // namespace
}  // namespace mrpt::fusion::test::pair_evidence_test
