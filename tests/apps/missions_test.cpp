// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the commands on missions and teams. */

#include <algorithm>
#include <nlohmann/json.hpp>

#include "run.h"

namespace {

using Json = nlohmann::json;

/** Rawlogs with the maps of several robots. */
class Missions : public AppTest {
 protected:
  size_t sizeOf(const std::string& file) const { return fs::file_size(dir_ / file); }
  size_t gzippedSizeOf(const std::string& path) const {
    const auto r = run("gzip -6 -n -c " + path + " | wc -c");
    return std::stoul(r.out);
  }
};

TEST_F(Missions, AreFused) {
  ASSERT_EQ(mapFusion("pack " + both() + " -o mission.rawlog").code, 0);
  const auto r = mapFusion("fuse mission.rawlog -o fused.ot --json report.json");
  ASSERT_EQ(r.code, 0) << r.out << r.err;
  const Json robots = report().at("robots");
  ASSERT_EQ(robots.size(), 2U);
  EXPECT_EQ(robots[0].at("robot"), "map_a");
  EXPECT_FALSE(robots[0].contains("match"));
  EXPECT_EQ(robots[1].at("robot"), "map_b");
  EXPECT_TRUE(robots[1].at("joined"));
  const auto truth = readMatrix(pair("T_a_b.txt"));
  for (int row = 0; row < 3; row++)
    EXPECT_NEAR(robots[1].at("pose").at("matrix")[row][3], truth(row, 3), 0.1);

  // The files of the robots give the same result.
  ASSERT_EQ(mapFusion("fuse " + both() + " -o direct.ot").code, 0);
  EXPECT_TRUE(readFile(dir_ / "fused.ot") == readFile(dir_ / "direct.ot"));
}

TEST_F(Missions, TellFilesOfOneNameApartByTheirFolders) {
  ASSERT_EQ(run("mkdir -p one/maps two/maps && cp " + pair("map_a.ot") + " one/maps/map.ot && cp " +
                pair("map_b.ot") + " two/maps/map.ot")
                .code,
            0);
  const auto r = mapFusion("pack one/maps/map.ot two/maps/map.ot -o mission.rawlog");
  ASSERT_EQ(r.code, 0) << r.err;
  ASSERT_EQ(mapFusion("fuse mission.rawlog -o fused.ot --json report.json").code, 0);
  EXPECT_EQ(report().at("robots")[0].at("robot"), "one_maps_map");
  EXPECT_EQ(report().at("robots")[1].at("robot"), "two_maps_map");
  const auto same = mapFusion("pack one/maps/map.ot one/../one/maps/map.ot -o twice.rawlog");
  EXPECT_EQ(same.code, 0) << same.err;
  EXPECT_NE(same.err.find("is given twice, and counts once"), std::string::npos) << same.err;
  ASSERT_EQ(mapFusion("info twice.rawlog --json report.json").code, 0);
  EXPECT_EQ(report().at("maps").size(), 1U);
}

TEST_F(Missions, CarryMapsWithoutLossInHalfOfWhatGzipMakesOfThem) {
  for (const std::string name : {"map_a", "map_b"}) {
    ASSERT_EQ(mapFusion("pack " + pair(name + ".ot") + " -o " + name + ".rawlog").code, 0);
    EXPECT_LE(static_cast<double>(sizeOf(name + ".rawlog")),
              0.6 * static_cast<double>(gzippedSizeOf(pair(name + ".ot"))));
    ASSERT_EQ(
        mapFusion("pack --smallest " + pair(name + ".ot") + " -o " + name + "_small.rawlog").code,
        0);
    EXPECT_LE(static_cast<double>(sizeOf(name + "_small.rawlog")),
              0.5 * static_cast<double>(gzippedSizeOf(pair(name + ".ot"))));
    ASSERT_EQ(mapFusion("transform " + name + ".rawlog --pose \"[0 0 0 0 0 0]\" -o back.ot").code,
              0);
    ASSERT_EQ(
        mapFusion("transform " + pair(name + ".ot") + " --pose \"[0 0 0 0 0 0]\" -o same.ot").code,
        0);
    EXPECT_TRUE(readFile(dir_ / "back.ot") == readFile(dir_ / "same.ot"));
    ASSERT_EQ(
        mapFusion("transform " + name + "_small.rawlog --pose \"[0 0 0 0 0 0]\" -o back.ot").code,
        0);
    EXPECT_TRUE(readFile(dir_ / "back.ot") == readFile(dir_ / "same.ot"));
  }
}

TEST_F(Missions, CarryEdgesInATwentiethOfThat) {
  ASSERT_EQ(mapFusion("pack --edges-only " + pair("map_b.ot") + " -o edges.rawlog").code, 0);
  EXPECT_LE(static_cast<double>(sizeOf("edges.rawlog")),
            0.05 * static_cast<double>(gzippedSizeOf(pair("map_b.ot"))));
  const auto r =
      mapFusion("match " + pair("map_a.ot") + " edges.rawlog --pose-out T.txt --json report.json");
  EXPECT_EQ(r.code, 3) << "edges are not accepted as a match to merge by";
  EXPECT_TRUE(report().at("match").at("by_edges"));
  const auto found = readMatrix(dir_ / "T.txt"), truth = readMatrix(pair("T_a_b.txt"));
  EXPECT_LT((found.translation() - truth.translation()).norm(), 0.3) << "but tell where they meet";
  EXPECT_EQ(mapFusion("match " + both() + " --init T.txt").code, 0);
}

TEST_F(Missions, WithARobotFromElsewhereAreFusedAsFarAsTheyCanBe) {
  ASSERT_EQ(
      mapFusion("build /usr/share/mrpt/datasets/localization_demo.simplemap.gz -o plane.ot").code,
      0);
  const auto r = mapFusion("fuse " + pair("map_a.ot") + " plane.ot " + pair("map_b.ot") +
                           " -o fused.ot --poses-out poses.tum");
  EXPECT_EQ(r.code, 3) << r.out;
  EXPECT_TRUE(fs::exists(dir_ / "fused.ot"));
  const std::string poses = readFile(dir_ / "poses.tum");
  EXPECT_NE(poses.find("\n2 31."), std::string::npos) << poses;
  EXPECT_EQ(poses.find("\n1 "), std::string::npos) << "not placed\n" << poses;
  EXPECT_EQ(mapFusion("fuse " + pair("map_a.ot") + " plane.ot " + " -o two.ot").code, 3);
  EXPECT_FALSE(fs::exists(dir_ / "two.ot"));
}

TEST_F(Missions, OfOneWholeMapAndEdgesMergeNothing) {
  ASSERT_EQ(mapFusion("pack --edges-only " + pair("map_b.ot") + " -o edges.rawlog").code, 0);
  ASSERT_EQ(mapFusion("pack " + pair("map_a.ot") + " edges.rawlog -o mission.rawlog").code, 0);
  const auto r = mapFusion("fuse mission.rawlog -o fused.ot");
  EXPECT_EQ(r.code, 3) << r.out;
  EXPECT_NE(r.err.find("nothing was merged"), std::string::npos) << r.err;
  EXPECT_EQ(r.err.find("--force"), std::string::npos) << "that would not help";
  EXPECT_FALSE(fs::exists(dir_ / "fused.ot"));
}

TEST_F(Missions, GoThroughPipes) {
  const std::string pack = std::string(MAP_FUSION) + " pack " + pair("map_b.ot") + " -o ";
  const auto named = run("mkfifo pipe; timeout 60 cat pipe > named.rawlog & " + pack +
                         "pipe; code=$?; wait; exit $code");
  EXPECT_EQ(named.code, 0) << named.err;
  EXPECT_EQ(mapFusion("info named.rawlog").code, 0);
  const auto piped = run(pack + "/dev/stdout | cat > piped.rawlog");
  EXPECT_NE(piped.err.find("map_b"), std::string::npos) << "the summary, where it is in no way";
  EXPECT_EQ(mapFusion("info piped.rawlog").code, 0) << "nothing follows the maps";
}

TEST_F(Missions, AreListed) {
  ASSERT_EQ(mapFusion("pack " + both() + " -o mission.rawlog").code, 0);
  const auto r = mapFusion("info mission.rawlog");
  EXPECT_EQ(r.code, 0);
  EXPECT_NE(r.out.find("map_a"), std::string::npos);
  EXPECT_NE(r.out.find("map_b"), std::string::npos);
}

TEST_F(Missions, ThatCannotBeUsedSayWhy) {
  ASSERT_EQ(mapFusion("pack " + both() + " -o mission.rawlog").code, 0);
  EXPECT_EQ(mapFusion("match mission.rawlog " + pair("map_b.ot")).code, 1) << "which of its maps?";
  EXPECT_EQ(mapFusion("fuse " + pair("map_a.ot") + " -o fused.ot").code, 2) << "with what?";
  EXPECT_EQ(mapFusion("fuse mission.rawlog --init \"[0 0 0 0 0 0]\" -o fused.ot").code, 2);
  const auto twice = mapFusion("fuse mission.rawlog " + pair("map_b.ot") + " " + pair("map_a.ot") +
                               " -o fused.ot");
  EXPECT_EQ(twice.code, 1);
  EXPECT_NE(twice.err.find("two maps of 'map_b'"), std::string::npos) << twice.err;
  ASSERT_EQ(run("head -c 100000 mission.rawlog > cut.rawlog").code, 0);
  const auto cut = mapFusion("fuse cut.rawlog -o fused.ot");
  EXPECT_EQ(cut.code, 1);
  EXPECT_NE(cut.err.find("cut.rawlog: "), std::string::npos) << cut.err;
  EXPECT_FALSE(fs::exists(dir_ / "fused.ot"));
}

TEST_F(Missions, OfRobotsWhoseNamesWouldControlATerminalPrintThemEscaped) {
  ASSERT_EQ(run("cp " + pair("map_a.ot") + " \"$(printf 'a\\033[31m\\007')\".ot && cp " +
                pair("map_b.ot") + " \"$(printf 'b\\033]0;title\\007')\".ot")
                .code,
            0);
  ASSERT_EQ(mapFusion("pack a*.ot b*.ot -o mission.rawlog").code, 0);
  for (const std::string command :
       {"info mission.rawlog", "fuse mission.rawlog -o fused.ot --json report.json",
        "fuse mission.rawlog mission.rawlog -o fused.ot", "match a*.ot none -q"}) {
    const auto r = mapFusion(command);
    const std::string all = r.out + r.err;
    EXPECT_TRUE(
        std::all_of(all.begin(), all.end(),
                    [](char c) { return c == '\n' || static_cast<unsigned char>(c) >= ' '; }))
        << command << "\n"
        << all;
  }
  EXPECT_EQ(report().at("robots")[0].at("robot"), "a\033[31m\007");
}

}  // namespace
