// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the commands on one map, of --full-6dof and of --help. */

#include <mrpt/slam/CProbabilisticMapMatching.h>
#include <octomap/octomap.h>

#include <nlohmann/json.hpp>

#include "run.h"

namespace {

class SingleSteps : public AppTest {};

TEST_F(SingleSteps, MatchesMapsWithoutACommonVertical) {
  ASSERT_EQ(
      mapFusion("transform " + pair("map_b.ot") + " --pose '[1 2 3 50 -20 90]' -o lying.ot").code,
      0);
  const std::string maps = "match " + pair("map_a.ot") + " lying.ot --pose-out T.txt";
  const auto upright = mapFusion(maps);
  EXPECT_EQ(upright.code, 3) << "up is not up";
  EXPECT_NE(upright.out.find("pass --full-6dof"), std::string::npos) << upright.out;
  const auto r = mapFusion(maps + " --full-6dof");
  ASSERT_EQ(r.code, 0) << r.out << r.err;
  const Eigen::Isometry3d lying = mrpt::fusion::toEigen(mrpt::poses::CPose3D(
      1, 2, 3, mrpt::DEG2RAD(50.0), mrpt::DEG2RAD(-20.0), mrpt::DEG2RAD(90.0)));
  const Eigen::Isometry3d off =
      readMatrix(pair("T_a_b.txt")).inverse() * readMatrix(dir_ / "T.txt") * lying;
  EXPECT_LT(off.translation().norm(), 0.1);
  EXPECT_LT(Eigen::AngleAxisd(off.linear()).angle(), mrpt::DEG2RAD(1.0));
  EXPECT_EQ(mapFusion(maps + " --full-6dof --init '[0 0 0 0 0 0]'").code, 2);
}

TEST_F(SingleSteps, EdgesAreAPointCloudWithDirections) {
  ASSERT_EQ(mapFusion("edges " + pair("map_a.ot") + " -o edges.ply --json report.json").code, 0);
  std::istringstream ply(readFile(dir_ / "edges.ply"));
  std::string line;
  size_t announced = 0, points = 0;
  while (std::getline(ply, line) && line != "end_header")
    if (line.rfind("element vertex ", 0) == 0) announced = std::stoul(line.substr(15));
  float x, y, z, nx, ny, nz, p, linearity;
  while (ply >> x >> y >> z >> nx >> ny >> nz >> p >> linearity) {
    points++;
    EXPECT_NEAR(nx * nx + ny * ny + nz * nz, 1, 1e-3);
    EXPECT_GE(p, 0.5F);
    EXPECT_LE(p, 1.F);
  }
  EXPECT_EQ(points, announced);
  const auto report = nlohmann::json::parse(readFile(dir_ / "report.json"));
  const double share =
      static_cast<double>(points) / report.at("maps").at(0).at("occupied_voxels").get<double>();
  EXPECT_GT(share, 0.03) << "of the occupied voxels of a real building at 0.1 m";
  EXPECT_LT(share, 0.10);
}

TEST_F(SingleSteps, TransformMovesTheMap) {
  octomap::OcTree tree(0.1);
  tree.updateNode(0.05, 0.05, 0.05, true);
  ASSERT_TRUE(tree.write((dir_ / "one.ot").string()));
  ASSERT_EQ(mapFusion("transform one.ot --pose \"[1 2 3 90 0 0]\" -o moved.ot").code, 0);
  const std::unique_ptr<octomap::AbstractOcTree> read(
      octomap::AbstractOcTree::read((dir_ / "moved.ot").string()));
  const auto* moved = dynamic_cast<octomap::OcTree*>(read.get());
  ASSERT_NE(moved, nullptr);
  EXPECT_EQ(moved->getNumLeafNodes(), 1U);
  const auto* voxel = moved->search(1 - 0.05, 2 + 0.05, 3 + 0.05);
  ASSERT_NE(voxel, nullptr);
  EXPECT_FLOAT_EQ(voxel->getLogOdds(), tree.getProbHitLog());
}

TEST_F(SingleSteps, BuildTakesTheMapClassFromAnIniFile) {
  writeFile(dir_ / "map.ini",
            "[MappingApplication]\nprobOctoMap_count = 1\n"
            "[MappingApplication_probOctoMap_00_creationOpts]\nresolution = 0.25\n");
  ASSERT_EQ(mapFusion("build " + pair("robot_a.rawlog") +
                      " --config map.ini -o map.ot --json report.json")
                .code,
            0);
  EXPECT_EQ(
      nlohmann::json::parse(readFile(dir_ / "report.json")).at("maps").at(0).at("resolution_m"),
      0.25);

  writeFile(dir_ / "points.ini", "[MappingApplication]\npointsMap_count = 1\n");
  EXPECT_EQ(mapFusion("build " + pair("robot_a.rawlog") + " --config points.ini -o points.gz").code,
            0)
      << "any MRPT map class";
  EXPECT_EQ(mapFusion("build " + pair("robot_a.rawlog") + " --config points.ini -o points.ot").code,
            1)
      << "which need not be an octree";
}

TEST_F(SingleSteps, InfoTakesEveryKindOfFile) {
  ASSERT_EQ(mapFusion("transform " + pair("map_a.ot") + " --pose \"[0 0 0 0 0 0]\" -o a.bt").code,
            0);
  ASSERT_EQ(mapFusion("transform " + pair("map_a.ot") + " --pose \"[0 0 0 0 0 0]\" -o a.gz").code,
            0);
  fs::copy(dir_ / "a.bt", dir_ / "misnamed.rawlog");
  for (const std::string& file :
       {pair("map_a.ot"), std::string("a.bt"), std::string("a.gz"), std::string("misnamed.rawlog"),
        pair("robot_a.rawlog"),
        std::string("/usr/share/mrpt/datasets/localization_demo.simplemap.gz")})
    EXPECT_EQ(mapFusion("info " + file).code, 0) << file;
}

TEST_F(SingleSteps, AFileMayBeNamedByAnyBytes) {
  const std::string name = "caf\xe9.ot";  // Latin-1
  fs::copy_file(pair("map_a.ot"), dir_ / name);
  const auto r = mapFusion("info '" + name + "' --json report.json");
  ASSERT_EQ(r.code, 0) << r.err;
  EXPECT_NE(readFile(dir_ / "report.json").find("occupied_voxels"), std::string::npos);
}

TEST_F(SingleSteps, CompressedMapsAreSavedByManyAtOnce) {
  run("for name in a b c d; do " MAP_FUSION " transform -q " + pair("map_a.ot") +
      " --pose '[0 0 0 0 0 0]' -o $name.gz & done; wait");
  for (const std::string name : {"a.gz", "b.gz", "c.gz", "d.gz"}) {
    EXPECT_TRUE(readFile(dir_ / name) == readFile(dir_ / "a.gz")) << name;
    EXPECT_EQ(mapFusion("info -q " + name).code, 0) << name;
  }
}

TEST_F(SingleSteps, QuietIsSilentWithMrptsOctomapsToo) {
  writeFile(dir_ / "map.ini",
            "[MappingApplication]\noctoMap_count = 1\n"
            "[MappingApplication_octoMap_00_creationOpts]\nresolution = 0.25\n");
  for (const std::string& command :
       {"build " + pair("robot_a.rawlog") + " --config map.ini -o map.gz",
        std::string("info map.gz"), std::string("pack map.gz -o mission.rawlog"),
        std::string("info mission.rawlog"),
        std::string("transform map.gz --pose '[0 0 0 0 0 0]' -o map.bt")}) {
    const auto r = mapFusion(command + " -q");
    EXPECT_EQ(r.code, 0) << command;
    EXPECT_EQ(r.out + r.err, "") << command;
  }
}

TEST_F(SingleSteps, QuietIsSilent) {
  const auto r = mapFusion("info -q " + pair("map_a.ot"));
  EXPECT_EQ(r.code, 0);
  EXPECT_EQ(r.out + r.err, "");
}

TEST_F(SingleSteps, TellsItsVersion) {
  const auto r = mapFusion("--version");
  EXPECT_EQ(r.code, 0);
  EXPECT_EQ(r.out, "map-fusion " PROJECT_VERSION "\n");
}

TEST_F(SingleSteps, HelpHasAnExampleForEverySubcommand) {
  EXPECT_EQ(mapFusion("--help").code, 0);
  for (const std::string command :
       {"fuse", "match", "evaluate", "merge", "edges", "transform", "build", "pack", "info"}) {
    const auto r = mapFusion(command + " --help");
    EXPECT_EQ(r.code, 0);
    EXPECT_NE(r.out.find("map-fusion " + command), std::string::npos) << command;
  }
}

}  // namespace
