// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/obs/CRawlog.h>

#include "mrpt_programs.h"

namespace {

/** A rawlog of two robots' maps, in rawlog-edit. */
class InstalledMissions : public MrptPrograms {
 protected:
  void SetUp() override {
    MrptPrograms::SetUp();
    const auto packed = run(mapFusion() + " pack " + pair("map_a.ot") + " " + pair("map_b.ot") +
                            " -o mission.rawlog");
    ASSERT_EQ(packed.code, 0) << packed.err;
  }
  Result edit(const std::string& operation) const {
    return run("rawlog-edit --plugins " + plugin() + " -i mission.rawlog " + operation);
  }
};

TEST_F(InstalledMissions, AreListedByRobot) {
  const auto r = edit("--info");
  EXPECT_EQ(r.code, 0);
  EXPECT_NE(r.out.find("All sensor labels                 : map_a, map_b"), std::string::npos)
      << r.out;
  EXPECT_EQ(r.err, "");
}

TEST_F(InstalledMissions, AreDescribed) {
  const auto r = edit("--describe");
  EXPECT_EQ(r.code, 0);
  for (const std::string robot : {"map_a", "map_b"})
    EXPECT_NE(r.out.find("Map number 0 of robot '" + robot + "'"), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("Map: Probabilistic octomap, voxels of 0.100 m, "), std::string::npos)
      << r.out;
}

TEST_F(InstalledMissions, AreExportedAsText) {
  EXPECT_EQ(edit("--export-txt").code, 0);
  std::istringstream text(readFile(dir_ / "mission_map_b.txt"));
  std::string header, row;
  ASSERT_TRUE(std::getline(text, header) && std::getline(text, row));
  std::istringstream names(header), values(row);
  std::string name, value;
  ASSERT_TRUE(names >> name);  // the comment sign
  std::vector<std::string> columns;
  while (names >> name) columns.push_back(name);
  EXPECT_EQ(columns, (std::vector<std::string>{"Time", "sequence", "x", "y", "z", "yaw", "pitch",
                                               "roll", "map"}));
  size_t numbers = 0;
  for (double v; values >> v;) numbers++;
  EXPECT_EQ(numbers, columns.size() - 1) << row;
  EXPECT_NE(row.find("\"Probabilistic octomap, "), std::string::npos) << row;
}

TEST_F(InstalledMissions, AreFilteredByRobotWithoutLoss) {
  ASSERT_EQ(edit("-o b.rawlog --keep-label map_b").code, 0);
  const auto transformed = [&](const std::string& map, const std::string& to) {
    return run(mapFusion() + " transform " + map + " --pose '[0 0 0 0 0 0]' -o " + to).code;
  };
  ASSERT_EQ(transformed("b.rawlog", "kept.ot"), 0);
  ASSERT_EQ(transformed(pair("map_b.ot"), "sent.ot"), 0);
  EXPECT_TRUE(readFile(dir_ / "kept.ot") == readFile(dir_ / "sent.ot"));
}

}  // namespace
