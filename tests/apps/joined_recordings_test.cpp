// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of recordings that are fused to one recording. */

#include <mrpt/fusion/voxels.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "run.h"
#include "support/keyframes.h"

namespace {

using Keys = std::set<std::tuple<unsigned, unsigned, unsigned>>;

class JoinedRecordings : public AppTest {
 protected:
  /** Writes the recording of a robot as a simplemap. */
  void write(const std::string& file, const std::string& robot, size_t every = 1) const {
    const auto frames = map_tests::keyframesOf(pair("robot_" + robot + ".rawlog"), every);
    ASSERT_TRUE(frames.saveToFile((dir_ / file).string()));
  }
  void writeBoth() const {
    write("a.simplemap", "a");
    write("b.simplemap", "b");
  }
  size_t framesOf(const std::string& file) const {
    mrpt::maps::CSimpleMap frames;
    EXPECT_TRUE(frames.loadFromFile((dir_ / file).string())) << file;
    return frames.size();
  }
  Keys occupied(const std::string& file) const {
    const std::unique_ptr<octomap::AbstractOcTree> tree(
        octomap::AbstractOcTree::read((dir_ / file).string()));
    Keys keys;
    const auto voxels =
        mrpt::fusion::extractOccupiedVoxels(dynamic_cast<const octomap::OcTree&>(*tree));
    for (const auto& k : voxels.key) keys.emplace(k[0], k[1], k[2]);
    return keys;
  }
  /** Returns the share of voxels with a voxel of the other map at most a number of voxels away. */
  static double shareNear(const Keys& keys, const Keys& others, unsigned distance) {
    size_t near = 0;
    for (const auto& [x, y, z] : keys) {
      bool found = false;
      for (unsigned i = x - distance; i <= x + distance; i++)
        for (unsigned j = y - distance; j <= y + distance; j++)
          for (unsigned k = z - distance; k <= z + distance; k++)
            found = found || others.count({i, j, k}) > 0;
      near += found;
    }
    return static_cast<double>(near) / static_cast<double>(keys.size());
  }
  /** Returns the F1 score of two maps. */
  double f1Of(const std::string& file, const std::string& other, unsigned distance) const {
    const Keys a = occupied(file), b = occupied(other);
    const double precision = shareNear(a, b, distance), recall = shareNear(b, a, distance);
    return 2 * precision * recall / (precision + recall);
  }
};

TEST_F(JoinedRecordings, GiveTheMapOfBothRobots) {
  writeBoth();
  auto r = mapFusion("fuse a.simplemap b.simplemap -o joined.simplemap --json report.json");
  ASSERT_EQ(r.code, 0) << r.out << r.err;
  const auto report = nlohmann::json::parse(readFile(dir_ / "report.json"));
  EXPECT_EQ(report.at("key_frames"), framesOf("a.simplemap") + framesOf("b.simplemap"));
  EXPECT_EQ(framesOf("joined.simplemap"), framesOf("a.simplemap") + framesOf("b.simplemap"));
  EXPECT_NE(r.out.find("key frames"), std::string::npos) << r.out;
  // From both recordings with the true pose
  ASSERT_EQ(
      mapFusion("merge a.simplemap b.simplemap --pose " + pair("T_a_b.txt") + " -o truth.simplemap")
          .code,
      0);
  for (const std::string file : {"joined", "truth"})
    ASSERT_EQ(mapFusion("build " + file + ".simplemap -o " + file + ".ot").code, 0);
  // The robots drift by some centimetres: at no pose of B do all points fall into the same voxels.
  EXPECT_GE(f1Of("joined.ot", "truth.ot", 1), 0.95);
}

TEST_F(JoinedRecordings, OfATeamHaveTheKeyFramesOfAllThatJoined) {
  writeBoth();
  write("c.simplemap", "b", 2);
  const auto r =
      mapFusion("fuse a.simplemap b.simplemap c.simplemap -o joined.simplemap --json report.json");
  ASSERT_TRUE(r.code == 0 || r.code == 3) << r.out << r.err;
  const auto robots = nlohmann::json::parse(readFile(dir_ / "report.json")).at("robots");
  ASSERT_EQ(robots.size(), 3U);
  size_t frames = 0, joined = 0;
  for (const auto& robot : robots)
    if (robot.at("joined")) {
      frames += framesOf(robot.at("robot").get<std::string>() + ".simplemap");
      joined++;
    }
  EXPECT_GE(joined, 2U);
  EXPECT_EQ(framesOf("joined.simplemap"), frames);
}

TEST_F(JoinedRecordings, HaveTheKeyFramesOfCopiesOnce) {
  write("a.simplemap", "a");
  fs::copy_file(dir_ / "a.simplemap", dir_ / "copy.simplemap");
  const auto r = mapFusion("fuse a.simplemap copy.simplemap -o joined.simplemap");
  ASSERT_EQ(r.code, 0) << r.out << r.err;
  EXPECT_EQ(framesOf("joined.simplemap"), framesOf("a.simplemap"));
}

TEST_F(JoinedRecordings, AreNotWrittenIfTheMatchIsRejected) {
  writeBoth();
  const auto r = mapFusion(
      "fuse a.simplemap b.simplemap --init '[0 30 0 90 0 0]' --init-sigma 0.1 1 -o "
      "joined.simplemap");
  EXPECT_EQ(r.code, 3) << r.out << r.err;
  EXPECT_FALSE(fs::exists(dir_ / "joined.simplemap"));
}

TEST_F(JoinedRecordings, NeedSimplemaps) {
  write("a.simplemap", "a", 6);
  for (const std::string& other : {pair("map_b.ot"), pair("robot_b.rawlog")})
    for (const std::string& inputs : {"a.simplemap " + other, "a.simplemap a.simplemap " + other}) {
      const auto r = mapFusion("fuse " + inputs + " -o joined.simplemap");
      EXPECT_EQ(r.code, 1) << inputs;
      EXPECT_NE(r.err.find(other + ": is not a simplemap"), std::string::npos) << r.err;
      EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
      EXPECT_FALSE(fs::exists(dir_ / "joined.simplemap"));
    }
}

}  // namespace
