// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of fused maps that carry their sources. */

#include <nlohmann/json.hpp>

#include "run.h"

namespace {

using Json = nlohmann::json;

class SourcesOfMaps : public AppTest {
 protected:
  /** Writes the voxels of a map to an octree file that can be compared. */
  std::string voxelsOf(const std::string& map) const {
    EXPECT_EQ(mapFusion("transform " + map + " --pose \"[0 0 0 0 0 0]\" -o voxels.ot -q").code, 0);
    return readFile(dir_ / "voxels.ot");
  }
};

TEST_F(SourcesOfMaps, AMapAndItsCopyCountOnce) {
  const std::string a = pair("map_a.ot");
  ASSERT_EQ(run("cp " + a + " copy.ot").code, 0);
  const auto r = mapFusion("fuse " + a + " copy.ot -o fused.ot --json report.json");
  EXPECT_EQ(r.code, 0) << r.out;
  EXPECT_NE(r.err.find("copy.ot: has the same voxels as " + a), std::string::npos) << r.err;
  EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
  EXPECT_TRUE(voxelsOf("fused.ot") == voxelsOf(a));
  EXPECT_EQ(report().at("counts").at("a"), "all");
  EXPECT_EQ(report().at("counts").at("b"), "copy");
  EXPECT_NE(report().at("notes")[0].get<std::string>().find("--independent"), std::string::npos);

  ASSERT_EQ(mapFusion("fuse " + a + " copy.ot -o twice.ot --independent --json report.json").code,
            0);
  EXPECT_FALSE(voxelsOf("twice.ot") == voxelsOf(a));
  EXPECT_EQ(report().at("counts").at("b"), "all");
}

TEST_F(SourcesOfMaps, AtAGivenPoseACopyCountsOnceWhereTheMapIs) {
  const std::string maps = pair("map_a.ot") + " " + pair("map_a.ot");
  ASSERT_EQ(mapFusion("merge " + maps + " --pose \"[0 0 0 0 0 0]\" -o once.ot").code, 0);
  EXPECT_TRUE(voxelsOf("once.ot") == voxelsOf(pair("map_a.ot")));
  ASSERT_EQ(
      mapFusion("merge " + maps + " --pose \"[3 0 0 0 0 0]\" -o both.ot --json report.json").code,
      0);
  EXPECT_EQ(report().at("counts").at("b"), "all");
}

TEST_F(SourcesOfMaps, AFusedMapAddsNoSourceAgain) {
  for (const std::string fused : {"fused.gridmap", "fused.rawlog"}) {
    ASSERT_EQ(mapFusion("fuse " + both() + " -o fused.gridmap").code, 0);
    ASSERT_EQ(mapFusion("pack fused.gridmap -o fused.rawlog").code, 0);
    const auto r = mapFusion("fuse " + fused + " " + pair("map_b.ot") +
                             " -o again.gridmap --json report.json");
    ASSERT_EQ(r.code, 0) << r.out;
    EXPECT_NE(r.err.find("map_b"), std::string::npos) << r.err;
    EXPECT_TRUE(voxelsOf("again.gridmap") == voxelsOf("fused.gridmap"));
    const Json maps = report().at("maps");
    EXPECT_EQ(maps.back().at("sources").size(), 2U);
    EXPECT_EQ(maps.back().at("sources")[1].at("map"), "map_b");
  }
  const auto info = mapFusion("info fused.gridmap");
  EXPECT_NE(info.out.find("sources of map: map_a, map_b"), std::string::npos) << info.out;
}

TEST_F(SourcesOfMaps, OfFilesOfOneNameAreToldApartByTheirFolders) {
  ASSERT_EQ(run("mkdir one two && cp " + pair("map_a.ot") + " one/map.ot && cp " +
                pair("map_b.ot") + " two/map.ot")
                .code,
            0);
  ASSERT_EQ(mapFusion("fuse one/map.ot two/map.ot -o fused.gridmap").code, 0);
  const auto info = mapFusion("info fused.gridmap");
  EXPECT_NE(info.out.find("sources of map: one_map, two_map"), std::string::npos) << info.out;
}

TEST_F(SourcesOfMaps, AFusedMapThatIsMovedKeepsItsSources) {
  ASSERT_EQ(mapFusion("fuse " + both() + " -o fused.gridmap").code, 0);
  ASSERT_EQ(mapFusion("transform fused.gridmap --pose \"[1 2 0 30 0 0]\" -o moved.gridmap").code,
            0);
  const auto r =
      mapFusion("fuse moved.gridmap " + pair("map_b.ot") + " -o again.gridmap --json report.json");
  ASSERT_EQ(r.code, 0) << r.out;
  EXPECT_EQ(report().at("counts").at("b"), "none");
  EXPECT_TRUE(voxelsOf("again.gridmap") == voxelsOf("moved.gridmap"));
}

TEST_F(SourcesOfMaps, OfATeamCountOnce) {
  ASSERT_EQ(run("cp " + pair("map_b.ot") + " copy.ot").code, 0);
  const auto r = mapFusion("fuse " + both() + " copy.ot -o fused.gridmap --json report.json");
  ASSERT_EQ(r.code, 0) << r.out;
  const Json robots = report().at("robots");
  EXPECT_EQ(robots[0].at("counts"), "all");
  // The first by name counts.
  EXPECT_EQ(robots[2].at("counts"), "all");
  EXPECT_EQ(robots[1].at("counts"), "copy");
  EXPECT_EQ(robots[1].at("counts_with"), "copy");
  EXPECT_EQ(report().at("maps").back().at("sources").size(), 2U);
}

}  // namespace
