// SPDX-License-Identifier: BSD-3-Clause
#include "mrpt_programs.h"

namespace {

class InstalledApp : public MrptPrograms {};

TEST_F(InstalledApp, BringsNoMapClassesOfMrptWithItUntilItNeedsThem) {
  const auto libraries = run("ldd " + mapFusion());
  EXPECT_NE(libraries.out.find("libmrpt-fusion-core"), std::string::npos) << libraries.out;
  for (const char* large : {"libmrpt-maps", "libmrpt-slam", "libmrpt-opengl", "libwx"})
    EXPECT_EQ(libraries.out.find(large), std::string::npos) << large;
}

TEST_F(InstalledApp, WithoutItsModuleStillFusesOctreesAndSaysWhatIsMissingForTheRest) {
  const auto copied = run("cp -a " INSTALLED_PREFIX
                          " app && find app -name libmap-fusion-mrpt.so "
                          "-print -delete");
  ASSERT_EQ(copied.code, 0) << copied.err;
  ASSERT_NE(copied.out, "") << "it is installed";
  const std::string app = "app/bin/map-fusion ";
  const auto fused = run(app + "fuse " + pair("map_a.ot") + " " + pair("map_b.ot") + " -o f.ot");
  EXPECT_EQ(fused.code, 0) << fused.err;
  EXPECT_TRUE(fs::exists(dir_ / "f.ot"));

  const auto none = run(app + "info none.ot");
  EXPECT_EQ(none.code, 1);
  EXPECT_NE(none.err.find("none.ot: cannot be opened"), std::string::npos) << none.err;

  const auto info = run(app + "info " + pair("robot_a.rawlog"));
  EXPECT_EQ(info.code, 1);
  EXPECT_EQ(std::count(info.err.begin(), info.err.end(), '\n'), 1) << info.err;
  EXPECT_NE(info.err.find("libmap-fusion-mrpt.so"), std::string::npos) << info.err;
}

TEST_F(InstalledApp, WithoutTheModuleOfTheLinkJoinSaysWhatIsMissing) {
  const auto copied =
      run("cp -a " INSTALLED_PREFIX " app && find app -name libmap-fusion-dds.so -delete");
  ASSERT_EQ(copied.code, 0) << copied.err;
  const auto join = run("app/bin/map-fusion join --robot r1 --for 1");
  EXPECT_EQ(join.code, 1);
  EXPECT_EQ(std::count(join.err.begin(), join.err.end(), '\n'), 1) << join.err;
  EXPECT_TRUE(join.err.find("libmap-fusion-dds.so") != std::string::npos ||
              join.err.find("CycloneDDS") != std::string::npos)
      << join.err;
}

TEST_F(InstalledApp, HasManualPagesAndCompletion) {
  const fs::path share = fs::path(INSTALLED_PREFIX) / "share";
  for (const char* file : {"man/man1/map-fusion.1", "man/man1/map-fusion-fuse.1",
                           "bash-completion/completions/map-fusion"})
    EXPECT_TRUE(fs::exists(share / file)) << file;
}

}  // namespace
