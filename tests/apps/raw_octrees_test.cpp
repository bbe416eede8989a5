// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the data of octomap_msgs/Octomap, which has no header, and of stamped octrees. */

#include <octomap/OcTree.h>
#include <octomap/OcTreeStamped.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "run.h"

namespace {

class RawOctrees : public AppTest {
 protected:
  static std::unique_ptr<octomap::OcTree> read(const std::string& file) {
    return std::unique_ptr<octomap::OcTree>(
        dynamic_cast<octomap::OcTree*>(octomap::AbstractOcTree::read(pair(file))));
  }
  /** Writes the nodes of a map as octomap_msgs::fullMapToMsg() and binaryMapToMsg() do. */
  void writeData(const std::string& name, const octomap::OcTree& map) const {
    std::ofstream full(dir_ / (name + ".full"), std::ios::binary);
    map.writeData(full);
    octomap::OcTree likely(map);
    likely.toMaxLikelihood();
    likely.prune();
    std::ofstream binary(dir_ / (name + ".binary"), std::ios::binary);
    likely.writeBinaryData(binary);
  }
  nlohmann::json infoOf(const std::string& arguments) const {
    const auto r = mapFusion("info " + arguments + " --json report.json");
    EXPECT_EQ(r.code, 0) << arguments << r.err;
    return nlohmann::json::parse(readFile(dir_ / "report.json")).at("maps").at(0);
  }
};

TEST_F(RawOctrees, AreMapsWithAResolution) {
  const auto map = read("map_a.ot");
  writeData("a", *map);
  const auto of_file = infoOf(pair("map_a.ot"));
  for (const std::string file : {"a.full", "a.binary"}) {
    const auto of_data = infoOf(file + " --resolution 0.1");
    for (const std::string key : {"resolution_m", "occupied_voxels", "free_voxels"})
      EXPECT_EQ(of_data.at(key), of_file.at(key)) << file << " " << key;
  }
  EXPECT_EQ(infoOf("a.full --resolution 0.25").at("resolution_m"), 0.25);
}

TEST_F(RawOctrees, AreFused) {
  writeData("a", *read("map_a.ot"));
  writeData("b", *read("map_b.ot"));
  const std::string init = " --init " + guess(0.2, 2) + " -o ";
  ASSERT_EQ(mapFusion("fuse " + both() + init + "expected.ot").code, 0);
  const auto r = mapFusion("fuse a.full b.full --resolution 0.1" + init + "fused.ot");
  EXPECT_EQ(r.code, 0) << r.out << r.err;
  EXPECT_TRUE(readFile(dir_ / "fused.ot") == readFile(dir_ / "expected.ot"));
}

TEST_F(RawOctrees, WithoutAResolutionAreNamed) {
  writeData("a", *read("map_a.ot"));
  for (const std::string command :
       {"info a.full", "build a.binary -o out.ot", "edges a.full -o out.ply"}) {
    const auto r = mapFusion(command);
    EXPECT_EQ(r.code, 1) << command;
    EXPECT_NE(r.err.find("needs --resolution"), std::string::npos) << r.err;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
  }
  EXPECT_EQ(mapFusion("build a.full --resolution 0.1 -o out.ot").code, 1) << "is a map already";
  EXPECT_FALSE(fs::exists(dir_ / "out.ot"));
}

TEST_F(RawOctrees, MayBeStamped) {
  octomap::OcTreeStamped stamped(0.1);
  const auto map = read("map_a.ot");
  for (auto leaf = map->begin_leafs(); leaf != map->end_leafs(); ++leaf)
    stamped.updateNode(leaf.getCoordinate(), map->isNodeOccupied(*leaf));
  ASSERT_TRUE(stamped.write((dir_ / "stamped.ot").string()));
  std::ofstream data(dir_ / "stamped.full", std::ios::binary);
  stamped.writeData(data);
  data.close();
  stamped.expand();
  size_t occupied = 0;
  for (auto leaf = stamped.begin_leafs(); leaf != stamped.end_leafs(); ++leaf)
    occupied += stamped.isNodeOccupied(*leaf);
  for (const std::string arguments : {"stamped.ot", "stamped.full --resolution 0.1"})
    EXPECT_EQ(infoOf(arguments).at("occupied_voxels"), occupied) << arguments;
}

}  // namespace
