// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of one map that grows by the maps that meet it. */
#include <gtest/gtest.h>
#include <mrpt/fusion/many_maps.h>
#include <mrpt/fusion/voxels.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "fusion_core/features/features.h"
#include "fusion_octree/resampling.h"
#include "support/apartment_pair.h"

namespace mrpt::fusion::test::greedy_growth_test {
namespace {

constexpr double kVoxel = 0.2;

/** Three robots in one apartment. Of x, `a` knows 0 to 65, `b` 30 to 99 and `c` 66 to 99 (cells of
 * 0.1 m): `a` and `c` share nothing. */
class Growing : public testing::Test {
 protected:
  static const ApartmentPair& pair() {
    static const ApartmentPair maps(kVoxel);
    return maps;
  }
  static Eigen::Isometry3d poseOfCInTheWorld() { return poseOf(-7, -3, -1, 140, 0.5, 0.4); }
  static const octomap::OcTree& mapC() {
    static const auto map = mrpt::fusion::transformOcTree(*apartment({66, 0, 0}, {99, 69, 25}),
                                                          poseOfCInTheWorld(), kVoxel);
    return *map;
  }
  /** The maps, prepared once for all tests that do not count that. */
  static const RobotMap& a() {
    static const RobotMap map{"a", PreparedMap(*pair().map_a)};
    return map;
  }
  static const RobotMap& b() {
    static const RobotMap map{"b", PreparedMap(*pair().map_b)};
    return map;
  }
  static const RobotMap& c() {
    static const RobotMap map{"c", PreparedMap(mapC())};
    return map;
  }
  static const ManyFused& fused() {
    static const ManyFused result = fuseMaps({a(), c(), b()}, {});
    return result;
  }
  static double metresOff(const FusionMember& member, const Eigen::Isometry3d& truth) {
    return metresBetween(toEigen(member.pose.mean), truth);
  }
  static size_t occupiedIn(const octomap::OcTree& map) { return statisticsOf(map).occupied; }

  const Eigen::Isometry3d T_a_c = pair().T_a_w * poseOfCInTheWorld().inverse();
};

TEST_F(Growing, ExtractsTheFeaturesOfEachMapOnce) {
  const octomap::OcTree &map_a = *pair().map_a, &map_b = *pair().map_b, &map_c = mapC();
  const size_t before = featureExtractions();
  const std::vector<RobotMap> maps = {
      {"a", PreparedMap(map_a)}, {"c", PreparedMap(map_c)}, {"b", PreparedMap(map_b)}};
  EXPECT_EQ(featureExtractions(), before + 3);
  const ManyFused result = fuseMaps(maps, {});
  for (const FusionMember& member : result.members) EXPECT_TRUE(member.joined) << member.robot;
  EXPECT_EQ(featureExtractions(), before + 3) << "none anew for a further match or a fused map";
}

TEST_F(Growing, MatchesNoPairTwice) {
  std::vector<std::pair<std::string, size_t>> matched;
  const ManyFused result = fuseMaps(
      {a(), c(), b()}, {}, false,
      [&](const std::string& robot, size_t joined) { matched.emplace_back(robot, joined); });
  ASSERT_TRUE(result.members[1].joined);
  // b with a; c with a and b. The order is that of the threads.
  std::sort(matched.begin(), matched.end());
  const std::vector<std::pair<std::string, size_t>> expected = {{"b", 1}, {"c", 1}, {"c", 2}};
  EXPECT_EQ(matched, expected);
}

TEST_F(Growing, MeetsThroughAThird) {
  ASSERT_EQ(fused().members.size(), 3U);
  const FusionMember& c_member = fused().members[1];
  ASSERT_TRUE(c_member.joined);
  EXPECT_EQ(c_member.matched_with, "b");
  EXPECT_LT(metresOff(c_member, T_a_c), 2 * kVoxel) << "two matches, a voxel each";
  EXPECT_LT(degreesBetween(toEigen(c_member.pose.mean), T_a_c), 2);
}

TEST_F(Growing, PoseThroughAThirdIsThatOfBothMatches) {
  const FusionMember &c_member = fused().members[1], &b_member = fused().members[2];
  EXPECT_EQ(b_member.matched_with, "a");
  EXPECT_TRUE(toEigen(b_member.pose.mean).isApprox(b_member.alignment.match.T_a_b, 1e-9));
  EXPECT_TRUE(toEigen(c_member.pose.mean)
                  .isApprox(b_member.alignment.match.T_a_b * c_member.alignment.match.T_a_b, 1e-9));
  EXPECT_GT(c_member.pose.cov.asEigen().diagonal().head<3>().sum(),
            c_member.alignment.pose().cov.asEigen().diagonal().head<3>().sum())
      << "both are uncertain";
}

TEST_F(Growing, TheFirstMapKeepsItsFrame) {
  const FusionMember& first = fused().members[0];
  EXPECT_EQ(first.robot, "a");
  EXPECT_TRUE(first.joined);
  EXPECT_FALSE(first.hasMatch());
  EXPECT_TRUE(first.matched_with.empty());
  EXPECT_TRUE(toEigen(first.pose.mean).isApprox(kIdentity, 0));
}

TEST_F(Growing, TheFusedMapHoldsWhatEachKnew) {
  const ManyFused of_two = fuseMaps({a(), b()}, {});
  EXPECT_GT(occupiedIn(*of_two.map), occupiedIn(*pair().map_a));
  // An obstacle that only b knows: the wall at x = 9.9 m.
  const Eigen::Vector3d wall = pair().T_a_w * Eigen::Vector3d(9.95, 5.5, 1.3);
  const auto isOccupiedNear = [&](const octomap::OcTree& map) {
    for (int dx = -1; dx <= 1; dx++)
      for (int dy = -1; dy <= 1; dy++) {
        const auto* node = map.search(wall.x() + dx * kVoxel, wall.y() + dy * kVoxel, wall.z());
        if (node && map.isNodeOccupied(node)) return true;
      }
    return false;
  };
  EXPECT_FALSE(isOccupiedNear(*pair().map_a));
  EXPECT_TRUE(isOccupiedNear(*of_two.map));
}

TEST_F(Growing, OfOneMapIsThatMap) {
  const ManyFused alone = fuseMaps({b()}, {});
  ASSERT_TRUE(alone.map);
  EXPECT_TRUE(*alone.map == *pair().map_b);
  EXPECT_TRUE(alone.members[0].joined);
}

TEST_F(Growing, LeavesTheMapsAsTheyWere) {
  fused();
  EXPECT_TRUE(*a().map.octree() == *pair().map_a);
  EXPECT_TRUE(*b().map.octree() == *pair().map_b);
}

TEST_F(Growing, LinksAreTheMatchesThatHoldTheMapsTogether) {
  const auto& members = fused().members;  // a, c, b
  EXPECT_TRUE(members[0].links.empty());
  ASSERT_EQ(members[1].links.size(), 1U);
  EXPECT_EQ(members[1].links[0].with, 2U) << "c is held by b";
  ASSERT_EQ(members[2].links.size(), 1U);
  EXPECT_EQ(members[2].links[0].with, 0U) << "b is held by a";
  for (const size_t k : {1U, 2U}) {
    const MatchResult& match = members[k].alignment.match;
    EXPECT_EQ(members[k].links[0].T_a_b.matrix(), match.T_a_b.matrix());
    EXPECT_EQ(members[k].links[0].covariance, match.covariance);
  }
}

TEST_F(Growing, OfTwoMapsHasOneLinkIfTheyJoin) {
  EXPECT_EQ(fuseMaps({a(), b()}, {}).members[1].links.size(), 1U);
  EXPECT_TRUE(fuseMaps({a(), c()}, {}).members[1].links.empty());
}

TEST_F(Growing, AGuessOfAPairIsItsPrior) {
  RobotMap guessed = b();
  const auto exact = [&](const Eigen::Isometry3d& T) {
    mrpt::poses::CPose3DPDFGaussian pdf(toPose(T));
    pdf.cov.setDiagonal(6, 1e-4);
    return Prior::gaussian(pdf);
  };
  Eigen::Isometry3d wrong = pair().truth;
  wrong.translation().x() += 30;
  guessed.guesses = {{"a", exact(wrong)}};
  EXPECT_FALSE(fuseMaps({a(), guessed}, {}).members[1].joined);
  guessed.guesses = {{"another robot", exact(wrong)}, {"a", exact(pair().truth)}};
  EXPECT_TRUE(fuseMaps({a(), guessed}, {}).members[1].joined);
  // The guess may be that of the other map.
  RobotMap other = a();
  other.guesses = {{"b", exact(wrong.inverse())}};
  EXPECT_FALSE(fuseMaps({other, b()}, {}).members[1].joined);
  other.guesses = {{"b", exact(pair().truth.inverse())}};
  EXPECT_TRUE(fuseMaps({other, b()}, {}).members[1].joined);
}

TEST_F(Growing, TheOrderOfTheOtherMapsDoesNotChangeABit) {
  const Eigen::Isometry3d T_d_w = poseOf(2, 5, 0.2, -70, 0.2, 0.3);
  const auto map_d = transformOcTree(*apartment({20, 0, 0}, {80, 69, 25}), T_d_w, kVoxel);
  const RobotMap d{"d", PreparedMap(*map_d)}, edges{"e", PreparedMap(pair().b.edges)};
  std::vector<RobotMap> rest = {b(), c(), d};
  const auto isBefore = [](const RobotMap& m, const RobotMap& n) { return m.robot < n.robot; };
  std::map<std::string, FusionMember> expected;
  std::unique_ptr<octomap::OcTree> expected_map;
  size_t orders = 0;
  do {
    std::vector<RobotMap> maps = rest;
    maps.insert(maps.begin(), a());
    maps.insert(maps.begin() + static_cast<std::ptrdiff_t>(orders % 5), edges);
    ManyFused result = fuseMaps(maps, {});
    orders++;
    if (!expected_map) {
      expected_map = std::move(result.map);
      for (const auto& m : result.members) expected[m.robot] = m;
      continue;
    }
    EXPECT_TRUE(*result.map == *expected_map);
    for (size_t k = 0; k < maps.size(); k++) {
      const FusionMember &m = result.members[k], &e = expected.at(maps[k].robot);
      EXPECT_EQ(m.robot, maps[k].robot);
      EXPECT_EQ(m.joined, e.joined) << m.robot;
      EXPECT_EQ(m.matched_with, e.matched_with) << m.robot;
      EXPECT_EQ(toEigen(m.pose.mean).matrix(), toEigen(e.pose.mean).matrix()) << m.robot;
      EXPECT_EQ(m.alignment.match.covariance, e.alignment.match.covariance) << m.robot;
      EXPECT_EQ(m.alignment.evaluation.reasons, e.alignment.evaluation.reasons) << m.robot;
      ASSERT_EQ(m.links.size(), e.links.size()) << m.robot;
      for (size_t i = 0; i < m.links.size(); i++)
        EXPECT_EQ(m.links[i].T_a_b.matrix(), e.links[i].T_a_b.matrix()) << m.robot;
    }
  } while (std::next_permutation(rest.begin(), rest.end(), isBefore));
  EXPECT_EQ(orders, 6U);
  EXPECT_TRUE(expected.at("b").joined && expected.at("c").joined && expected.at("d").joined);
}

TEST_F(Growing, WithoutAnyThatMeetsStaysTheFirstMap) {
  const ManyFused result = fuseMaps({a(), c()}, {});
  EXPECT_FALSE(result.members[1].joined);
  EXPECT_TRUE(result.members[1].hasMatch());
  EXPECT_EQ(result.members[1].matched_with, "a");
  EXPECT_TRUE(*result.map == *pair().map_a);
}

TEST_F(Growing, ACopyOfAMapFollowsThatMapAndChangesNoOther) {
  RobotMap copy_of_b = b(), copy_of_a = a();
  copy_of_b.robot = "d";
  copy_of_a.robot = "e";
  const ManyFused result = fuseMaps({a(), c(), copy_of_b, b(), copy_of_a}, {});
  for (const FusionMember& member : result.members) EXPECT_TRUE(member.joined) << member.robot;
  const auto pose = [&](size_t i) { return toEigen(result.members[i].pose.mean).matrix(); };
  EXPECT_EQ(pose(2), pose(3));
  EXPECT_TRUE(pose(4).isIdentity(0));
  for (const size_t k : {0, 1}) EXPECT_EQ(pose(k), toEigen(fused().members[k].pose.mean).matrix());
  EXPECT_TRUE(*result.map == *fused().map) << "copies count once";

  const ManyFused two = fuseMaps({a(), b(), copy_of_a}, {});
  EXPECT_TRUE(two.members[1].joined);
  EXPECT_TRUE(two.members[2].joined);
  EXPECT_TRUE(toEigen(two.members[2].pose.mean).matrix().isIdentity(0));
}

TEST_F(Growing, ForcedMapsOfATeamJoinAtTheirBestMatch) {
  const auto room = mrpt::fusion::transformOcTree(*apartment({0, 0, 0}, {20, 20, 25}),
                                                  poseOf(0, 0, 0, 90, 0, 0), kVoxel);
  const RobotMap part{"d", PreparedMap(*room)};
  Options strict;
  strict.evaluation.min_probability = 1;  // nothing is sure, and three maps close no loop
  const ManyFused rejected = fuseMaps({a(), c(), part}, strict);
  EXPECT_FALSE(rejected.members[2].joined);
  const ManyFused forced = fuseMaps({a(), c(), part}, strict, true);
  for (const size_t k : {1, 2}) {
    EXPECT_TRUE(forced.members[k].joined) << k;
    EXPECT_FALSE(forced.members[k].alignment.evaluation.accepted) << "forced, not accepted";
    EXPECT_EQ(toEigen(forced.members[k].pose.mean).matrix(),
              toEigen(rejected.members[k].pose.mean).matrix());
  }
}

TEST_F(Growing, EdgesAloneAreMatchedLastAndDoNotJoin) {
  const RobotMap edges{"e", PreparedMap(pair().b.edges)};
  std::vector<std::string> matched;
  const ManyFused result =
      fuseMaps({edges, a(), b()}, {}, false,
               [&](const std::string& robot, size_t) { matched.push_back(robot); });
  EXPECT_EQ(matched, (std::vector<std::string>{"b", "e", "e"}));
  EXPECT_FALSE(result.members[0].joined);
  EXPECT_TRUE(result.members[0].alignment.by_edges);
  EXPECT_LT(metresOff(result.members[0], pair().truth), 2 * kVoxel);
  EXPECT_FALSE(result.members[1].hasMatch()) << "the first whole map";
}

TEST_F(Growing, ErrorsNameTheRobot) {
  const RobotMap empty{"e", PreparedMap(octomap::OcTree(kVoxel))};
  const auto errorOf = [](const std::vector<RobotMap>& maps) {
    try {
      fuseMaps(maps, {});
    } catch (const std::exception& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_EQ(errorOf({a(), empty}), "e: map B has no occupied voxel");
  EXPECT_NE(errorOf({empty, a(), b()}).find("e: "), std::string::npos);
  EXPECT_NE(errorOf({empty, a(), b()}).find("the map has no occupied voxel"), std::string::npos);
  EXPECT_NE(errorOf({}).find("there is no map but edges"), std::string::npos);
  EXPECT_NE(errorOf({{"e", PreparedMap(pair().b.edges)}}), "");
}

}  // namespace
}  // namespace mrpt::fusion::test::greedy_growth_test
