// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/obs/CRawlog.h>

#include "mrpt_programs.h"

namespace {

class Plugin : public MrptPrograms {};

TEST_F(Plugin, LoadsTwiceAndAgainAfterItWasUnloaded) {
  const auto r = run(std::string(LOAD_PLUGIN) + " " + plugin());
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_EQ(r.out, "loaded\n");
}

TEST_F(Plugin, IsFoundWithItsPartsInAFolderThatTheLinkerDoesNotKnow) {
  const auto r = run("env -u LD_LIBRARY_PATH ldd " + plugin());
  const fs::path lib = fs::path(plugin()).parent_path();
  EXPECT_EQ(r.out.find("not found"), std::string::npos) << r.out;
  const size_t part = r.out.find("libmrpt-fusion-maps");
  ASSERT_NE(part, std::string::npos);
  const std::string line = r.out.substr(part, r.out.find('\n', part) - part);
  const std::string path = line.substr(line.find("=> ") + 3);
  EXPECT_TRUE(fs::equivalent(fs::path(path.substr(0, path.find(" ("))).parent_path(), lib)) << line;
}

TEST_F(Plugin, OfAnotherMrptIsRefusedInOneLine) {
  // As if built with another release, whose libraries are not here.
  const std::string folder = fs::path(plugin()).parent_path().string();
  const auto copied = run("cp -a " + folder + "/lib*.so* . && sed -i " +
                          "'s/libmrpt-maps[.]so[.][0-9][.][0-9]/libmrpt-maps.so.9.9/' lib*.so.?.*");
  ASSERT_EQ(copied.code, 0) << copied.err;
  const auto r = run(std::string(LOAD_PLUGIN) + " ./" + fs::path(plugin()).filename().string());
  EXPECT_EQ(r.code, 1);
  EXPECT_NE(r.err.find("libmrpt-maps.so.9.9: cannot open shared object file"), std::string::npos)
      << r.err;
}

TEST_F(Plugin, LetsRawlogEditReadAndWrite) {
  const std::string edit = "rawlog-edit --plugins " + plugin() + " -i ";
  const auto info = run(edit + pair("robot_a.rawlog") + " --info");
  EXPECT_EQ(info.code, 0);
  EXPECT_NE(info.out.find("All sensor labels                 : lidar, slam_pose"),
            std::string::npos)
      << info.out;
  const auto keep = run(edit + pair("robot_a.rawlog") + " -o poses.rawlog --keep-label slam_pose");
  EXPECT_EQ(keep.code, 0);
  mrpt::obs::CRawlog all, poses;
  ASSERT_TRUE(all.loadFromRawLogFile(pair("robot_a.rawlog")));
  ASSERT_TRUE(poses.loadFromRawLogFile((dir_ / "poses.rawlog").string()));
  EXPECT_GT(poses.size(), 10U);
  EXPECT_EQ(2 * poses.size(), all.size());
  EXPECT_EQ(info.err + keep.err, "");
}

TEST_F(Plugin, LetsRawlogEditReadLocalMapsWithinEachOtherWithoutACrash) {
  ASSERT_EQ(run(mapFusion() + " pack --edges-only " + pair("map_a.ot") + " -o one.rawlog").code, 0);
  const std::string one = readFile(dir_ / "one.rawlog");
  const size_t held = one.find("mrpt::maps::CEdgeVoxelMap") - 1;  // the length of the name
  ASSERT_LT(held, one.size());
  std::string many;
  for (int i = 0; i < 10'000; i++) many += one.substr(0, held);
  writeFile(dir_ / "many.rawlog", many + one);
  const auto r = run("rawlog-edit --plugins " + plugin() + " -i many.rawlog --info");
  EXPECT_EQ(r.code, 0) << r.err;
}

TEST_F(Plugin, LetsRawlogEditReadSetsOfMapsWithinEachOtherWithoutACrash) {
  const std::string set = "\x9bmrpt::maps::CMultiMetricMap\x0c" + std::string("\1\0\0\0", 4);
  std::string many;
  for (int i = 0; i < 100'000; i++) many += set;
  writeFile(dir_ / "many.rawlog", many);
  const auto r = run("rawlog-edit --plugins " + plugin() + " -i many.rawlog --info");
  EXPECT_EQ(r.code, 0) << r.err;
}

}  // namespace
