// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the commands on point clouds. */

#include <octomap/OcTree.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "run.h"
#include "support/cloud_files.h"
#include "support/gzip_bytes.h"

namespace {

using map_tests::pcdFile;
using map_tests::plyFile;
using map_tests::Points;
using octomap::point3d;

class PointClouds : public AppTest {
 protected:
  static std::unique_ptr<octomap::OcTree> read(const fs::path& file) {
    return std::unique_ptr<octomap::OcTree>(
        dynamic_cast<octomap::OcTree*>(octomap::AbstractOcTree::read(file.string())));
  }
  /** Returns the centres of the occupied voxels of a robot's map. */
  static Points pointsOf(const std::string& file) {
    const auto map = read(pair(file));
    map->expand();
    Points points;
    for (auto leaf = map->begin_leafs(); leaf != map->end_leafs(); ++leaf)
      if (map->isNodeOccupied(*leaf)) points.push_back(leaf.getCoordinate());
    return points;
  }
  /** Returns the figures of the map that `info` loads. */
  nlohmann::json infoOf(const std::string& arguments) const {
    const auto r = mapFusion("info " + arguments + " --json report.json");
    EXPECT_EQ(r.code, 0) << arguments << "\n" << r.err;
    auto maps = nlohmann::json::parse(readFile(dir_ / "report.json")).at("maps");
    EXPECT_EQ(maps.size(), 1U);
    return maps.at(0);
  }
};

TEST_F(PointClouds, AreMapsInAllFormats) {
  const Points points = pointsOf("map_a.ot");
  auto files = map_tests::cloudFiles(points);
  files.push_back({"packed.pcd.gz", map_tests::gzipped(files[1].bytes)});
  files.push_back({"named.rawlog", files[0].bytes});
  for (const auto& file : files) {
    writeFile(dir_ / file.name, file.bytes);
    const auto map = infoOf(file.name);
    EXPECT_EQ(map.at("resolution_m"), 0.1) << file.name;
    EXPECT_EQ(map.at("occupied_voxels"), points.size()) << file.name;
    EXPECT_EQ(map.at("free_voxels"), 0) << file.name;
  }
  EXPECT_EQ(infoOf("binary.pcd --resolution 0.4").at("resolution_m"), 0.4);
  EXPECT_GT(infoOf("binary.pcd --sensor-origin '3 1 1'").at("free_voxels"), 1000);
  EXPECT_EQ(infoOf("binary.pcd --sensor-origin '3 1 1'"),
            infoOf("binary.pcd --sensor-origin '[3 1 1]'"));
}

TEST_F(PointClouds, AreBuiltAsOctomapBuildsThem) {
  const Points points = pointsOf("map_a.ot");
  writeFile(dir_ / "cloud.pcd", pcdFile(points, "binary_compressed", "2.5 -1 1 1 0 0 0"));
  writeFile(dir_ / "cloud.ply", plyFile(points, "binary_little_endian"));
  const auto expectBuilt = [&](const std::string& arguments, const point3d& origin) {
    const auto r = mapFusion("build " + arguments + " --resolution 0.2 -o built.ot");
    ASSERT_EQ(r.code, 0) << r.err;
    octomap::OcTree expected(0.2);
    octomap::Pointcloud cloud;
    for (const auto& p : points) cloud.push_back(p);
    expected.insertPointCloud(cloud, origin, -1, true);
    expected.updateInnerOccupancy();
    expected.prune();
    EXPECT_TRUE(*read(dir_ / "built.ot") == expected) << arguments;
  };
  expectBuilt("cloud.pcd", {2.5F, -1, 1});
  expectBuilt("cloud.pcd --sensor-origin '0 0.5 1'", {0, 0.5F, 1});
  expectBuilt("cloud.ply --sensor-origin '-1 0 1'", {-1, 0, 1});
}

TEST_F(PointClouds, AreMatchedMergedAndMoved) {
  writeFile(dir_ / "a.ply", plyFile(pointsOf("map_a.ot"), "ascii"));
  writeFile(dir_ / "b.pcd", pcdFile(pointsOf("map_b.ot"), "binary"));
  auto r = mapFusion("match a.ply b.pcd --init " + guess(0.3, 3) + " --pose-out T.txt");
  EXPECT_NE(r.code, 1) << r.err;
  EXPECT_NE(r.out.find("free space"), std::string::npos) << r.out;
  const Eigen::Isometry3d error =
      readMatrix(dir_ / "T.txt").inverse() * readMatrix(pair("T_a_b.txt"));
  EXPECT_LT(error.translation().norm(), 0.1);
  for (const std::string& arguments : std::vector<std::string>{
           "merge a.ply b.pcd --pose T.txt -o merged.ot", "fuse a.ply b.pcd -o fused.ot --force",
           "fuse " + pair("map_a.ot") + " a.ply b.pcd -o team.ot",
           "transform b.pcd --pose T.txt --resolution 0.2 -o moved.ot", "edges a.ply -o edges.ply",
           "pack a.ply b.pcd -o mission.rawlog", "slice a.ply -o a.pgm"}) {
    r = mapFusion(arguments);
    EXPECT_NE(r.code, 1) << arguments << "\n" << r.err;
    EXPECT_NE(r.code, 2) << arguments << "\n" << r.err;
  }
  EXPECT_EQ(infoOf("moved.ot").at("resolution_m"), 0.2);
}

TEST_F(PointClouds, InMillimetresAreNotAccepted) {
  // The points are a grid of voxels. In voxels of 0.1 m they lie apart, and fit at all steps of it.
  for (const std::string map : {"a", "b"}) {
    Points points = pointsOf("map_" + map + ".ot");
    for (point3d& p : points) p *= 1000;
    writeFile(dir_ / (map + ".pcd"), pcdFile(points, "binary"));
  }
  for (const std::string rotations : {"", " --full-6dof"}) {
    const auto r = mapFusion("match a.pcd b.pcd" + rotations);
    EXPECT_EQ(r.code, 3) << r.out;
    EXPECT_NE(r.out.find("% of the occupied voxels of map A touch no other"), std::string::npos)
        << r.out;
    EXPECT_EQ(r.out.find("pass --full-6dof"), std::string::npos) << r.out;
  }
}

TEST_F(PointClouds, NoteWhatIsLeftOut) {
  Points points = pointsOf("map_a.ot");
  points.emplace_back(std::nanf(""), 0, 0);
  points.emplace_back(1e9F, 0, 0);
  writeFile(dir_ / "cloud.ply", plyFile(points, "binary_big_endian"));
  const auto r = mapFusion("build cloud.ply -o map.ot --json report.json");
  ASSERT_EQ(r.code, 0) << r.err;
  for (const std::string part :
       {"1 point without finite coordinates", "1 point outside", "mesh", "no free space"}) {
    EXPECT_NE(r.err.find("cloud.ply: "), std::string::npos) << r.err;
    EXPECT_NE(r.err.find(part), std::string::npos) << r.err;
    EXPECT_NE(readFile(dir_ / "report.json").find(part), std::string::npos);
  }
}

TEST_F(PointClouds, OfBadInputGiveOneLine) {
  const Points points = pointsOf("map_a.ot");
  const auto expectLine = [&](const std::string& arguments, const std::string& reason) {
    const auto r = mapFusion(arguments);
    EXPECT_EQ(r.code, 1) << arguments;
    EXPECT_NE(r.err.find(reason), std::string::npos) << r.err;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
    EXPECT_FALSE(fs::exists(dir_ / "out.ot")) << arguments;
  };
  const std::string good = pcdFile(points, "binary");
  writeFile(dir_ / "good.pcd", good);
  writeFile(dir_ / "cut.pcd", good.substr(0, good.size() - 1));
  writeFile(dir_ / "empty.ply", plyFile({}, "ascii"));
  for (const std::string& command :
       {std::string("build cut.pcd -o out.ot"), std::string("edges cut.pcd -o out.ply"),
        "fuse " + pair("map_a.ot") + " cut.pcd -o out.ot"})
    expectLine(command, "cut.pcd: point cloud (.pcd): the header announces");
  expectLine("build empty.ply -o out.ot", "empty.ply: the map has no occupied voxel");
  writeFile(dir_ / "far.ply", plyFile({{5e5F, 0, 0}, {6e5F, 1, 0}}, "ascii"));
  expectLine("build far.ply -o out.ot",
             "all points are outside of the grid of the map, which ends 3276.8 m from the origin");
  expectLine("build good.pcd --sensor-origin '1e9 0 0' -o out.ot", "outside of the grid");
  expectLine("build good.pcd --sensor-origin '0 0 0' --resolution 0.0005 -o out.ot", "good.pcd: ");
  expectLine("build " + pair("robot_a.rawlog") + " --resolution 0.2 -o out.ot", "is a recording");
}

TEST_F(PointClouds, OfWrongArgumentsAreUsageErrors) {
  writeFile(dir_ / "good.pcd", pcdFile(pointsOf("map_a.ot"), "binary"));
  for (const std::string arguments :
       {"--sensor-origin '1 2'", "--sensor-origin '1 2 3 4'", "--sensor-origin 'a b c'",
        "--sensor-origin 'nan 0 0'", "--sensor-origin '1,2,3'", "--resolution 0"}) {
    const auto r = mapFusion("build good.pcd -o out.ot " + arguments);
    EXPECT_EQ(r.code, 2) << arguments << "\n" << r.err;
    EXPECT_FALSE(fs::exists(dir_ / "out.ot")) << arguments;
  }
}

}  // namespace
