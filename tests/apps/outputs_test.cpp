// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of outputs: standard output, rights of files, and outputs that are one file. */

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <string>
#include <vector>

#include "run.h"

namespace {

class Outputs : public AppTest {
 protected:
  static std::string merge() { return "merge " + both() + " --pose " + pair("T_a_b.txt") + " -o "; }
  static std::string transform() {
    return "transform " + pair("map_a.ot") + " --pose '[1 2 0 30 0 0]' -o ";
  }
  void expectUsageError(const std::string& arguments) const {
    const auto r = mapFusion(arguments);
    EXPECT_EQ(r.code, 2) << arguments << "\n" << r.err;
    EXPECT_NE(r.err.find("two outputs are the same file"), std::string::npos) << r.err;
    EXPECT_EQ(r.out, "") << arguments;
  }
};

TEST_F(Outputs, OnStandardOutputAreTheBytesOfTheFile) {
  for (const auto& [command, file] : std::vector<std::pair<std::string, std::string>>{
           {merge(), "map.ot"},
           {transform(), "moved.ot"},
           {"build " + pair("robot_a.rawlog") + " -o ", "built.ot"},
           {"edges " + pair("map_a.ot") + " -o ", "edges.ply"}}) {
    ASSERT_EQ(mapFusion(command + file).code, 0) << command;
    const auto r = mapFusion(command + "-");
    EXPECT_EQ(r.code, 0) << command << r.err;
    EXPECT_GT(r.out.size(), 1000U) << command;
    EXPECT_TRUE(r.out == readFile(dir_ / file)) << command;
    EXPECT_NE(r.err, "") << "the report of " << command;
    EXPECT_FALSE(fs::exists(dir_ / "-")) << command;
    const auto quiet = mapFusion(command + "- -q");
    EXPECT_TRUE(quiet.out == r.out) << command;
    EXPECT_EQ(quiet.err, "") << command;
  }
}

TEST_F(Outputs, OnStandardOutputMayBeReadByTheNextCommand) {
  ASSERT_EQ(mapFusion(transform() + "moved.ot").code, 0);
  const auto r = run(MAP_FUSION " " + transform() + "- -q | cat > piped.ot");
  EXPECT_EQ(r.out + r.err, "");
  EXPECT_TRUE(readFile(dir_ / "piped.ot") == readFile(dir_ / "moved.ot"));
  EXPECT_EQ(mapFusion("info piped.ot").code, 0);
  // A mission holds the time at which it was packed, so no two are equal.
  ASSERT_EQ(run(MAP_FUSION " pack -q " + both() + " --edges-only -o - > team.rawlog").code, 0);
  EXPECT_NE(mapFusion("info team.rawlog").out.find("map_b"), std::string::npos);
}

TEST_F(Outputs, TheReportIsAnOutput) {
  ASSERT_EQ(mapFusion("info " + pair("map_a.ot") + " --json -").out.substr(0, 1), "{");
  const auto r = mapFusion("info " + pair("map_a.ot") + " --json ./- -q");
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_TRUE(fs::exists(dir_ / "-")) << "a file of this name";
}

TEST_F(Outputs, FullStandardOutputIsAnError) {
  if (!fs::is_character_file("/dev/full")) GTEST_SKIP() << "/dev/full is no device";
  const auto r = run(MAP_FUSION " " + transform() + "- -q > /dev/full");
  EXPECT_EQ(r.code, 1);
  EXPECT_NE(r.err.find("standard output: cannot be written"), std::string::npos) << r.err;
  EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
}

TEST_F(Outputs, MayNotBeOneFile) {
  writeFile(dir_ / "old.ot", "the old map");
  fs::create_symlink("old.ot", dir_ / "link.ot");
  fs::create_hard_link(dir_ / "old.ot", dir_ / "hard.ot");
  fs::create_directory(dir_ / "folder");
  ASSERT_EQ(::mkfifo((dir_ / "pipe").c_str(), 0600), 0);
  for (const auto& [one, other] :
       std::vector<std::pair<std::string, std::string>>{{"new.ot", "new.ot"},
                                                        {"new.ot", "./new.ot"},
                                                        {"new.ot", "folder/../new.ot"},
                                                        {"new.ot", "\"$PWD/new.ot\""},
                                                        {"old.ot", "link.ot"},
                                                        {"hard.ot", "old.ot"},
                                                        {"pipe", "./pipe"},
                                                        {"-", "-"},
                                                        {"-", "/dev/stdout"},
                                                        {"/dev/stdout", "/dev/stdout"}}) {
    expectUsageError(merge() + one + " --json " + other);
    expectUsageError("match " + both() + " --pose-out " + one + " --json " + other);
    expectUsageError("match " + both() + " --picture " + other + " --pose-out " + one);
  }
  EXPECT_EQ(readFile(dir_ / "old.ot"), "the old map");
  EXPECT_FALSE(fs::exists(dir_ / "new.ot"));
}

TEST_F(Outputs, MayNotBothBeThePipeOfStandardOutput) {
  for (const std::string other : {"-", "/dev/stdout"}) {
    run(MAP_FUSION " " + transform() + "- --json " + other + " 2>errors | cat >piped");
    EXPECT_NE(readFile(dir_ / "errors").find("two outputs are the same"), std::string::npos);
    EXPECT_EQ(readFile(dir_ / "piped"), "");
  }
}

TEST_F(Outputs, MayBothBeThrownAway) {
  if (!fs::is_character_file("/dev/null")) GTEST_SKIP() << "/dev/null is no device";
  EXPECT_EQ(mapFusion(transform() + "/dev/null --json /dev/null").code, 0);
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(Outputs, KeepTheRightsOfTheFilesThatTheyReplace) {
  const auto rightsOf = [this](const std::string& file) {
    struct stat st {};
    EXPECT_EQ(::stat((dir_ / file).c_str(), &st), 0) << file;
    return st.st_mode & 07777U;
  };
  const std::vector<std::string> files = {"map.ot", "map.bt", "map.gz", "report.json"};
  for (const mode_t rights : {0600U, 0640U, 0666U}) {
    for (const auto& file : files) {
      writeFile(dir_ / file, "old");
      ASSERT_EQ(::chmod((dir_ / file).c_str(), rights), 0);
    }
    for (const std::string file : {"map.ot", "map.bt", "map.gz"})
      ASSERT_EQ(run("umask 022; " MAP_FUSION " " + transform() + file + " --json report.json").code,
                0);
    for (const auto& file : files) {
      EXPECT_EQ(rightsOf(file), rights) << file;
      EXPECT_NE(readFile(dir_ / file), "old") << file;
    }
  }
  for (const auto& file : files) fs::remove(dir_ / file);
  ASSERT_EQ(run("umask 027; " MAP_FUSION " " + transform() + "map.ot --json report.json").code, 0);
  for (const std::string file : {"map.ot", "report.json"}) EXPECT_EQ(rightsOf(file), 0640U) << file;
}

}  // namespace
