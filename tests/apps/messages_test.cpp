// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of what the program says: files that it wrote, reasons of a rejection, hints. */

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "run.h"

namespace {

class Messages : public AppTest {
 protected:
  bool says(const std::string& text, const std::string& part) const {
    return text.find(part) != std::string::npos;
  }
  /** Runs a command that must fail by one line with a part. */
  void expectLine(const std::string& arguments, int code, const std::string& part) const {
    const auto r = mapFusion(arguments);
    EXPECT_EQ(r.code, code) << arguments << "\n" << r.err;
    EXPECT_TRUE(says(r.err, part)) << arguments << "\n" << r.err;
    EXPECT_EQ(r.out, "") << arguments;
  }
  /** Options with which the maps do not touch. */
  static std::string apart() { return " --init '[500 0 0 0 0 0]' --init-sigma 0.1 1"; }
};

TEST_F(Messages, NameTheWrittenFiles) {
  const std::string fuse = "fuse " + both() + " -o fused.ot --pose-out T.txt --json r.json";
  const auto first = mapFusion(fuse);
  ASSERT_EQ(first.code, 0) << first.err;
  EXPECT_TRUE(says(first.out,
                   "written          T.txt\n                 fused.ot\n"
                   "                 r.json\n"))
      << first.out;
  const auto second = mapFusion(fuse);
  EXPECT_TRUE(says(second.out, "fused.ot (replaced)\n")) << second.out;
  EXPECT_EQ(mapFusion(fuse + " -q").out, "");
}

TEST_F(Messages, DoNotNameAFileThatIsNotWritten) {
  const auto r = mapFusion("fuse " + both() + apart() + " -o fused.ot --pose-out T.txt");
  ASSERT_EQ(r.code, 3) << r.err;
  EXPECT_FALSE(says(r.out, "fused.ot")) << r.out;
  EXPECT_TRUE(says(r.out, "written          T.txt\n")) << r.out;
  EXPECT_TRUE(says(r.err, "do not touch at this pose; nothing was merged")) << r.err;
}

TEST_F(Messages, OfARejectionAreOneLineWithQuiet) {
  for (const std::string& command :
       {"match " + both() + apart() + " -q", "evaluate " + both() + " --pose '[500 0 0 0 0 0]' -q",
        "fuse " + both() + apart() + " -o fused.ot -q"}) {
    const auto r = mapFusion(command);
    EXPECT_EQ(r.code, 3) << command;
    EXPECT_EQ(r.out, "") << command;
    EXPECT_EQ(r.err.find("map-fusion: the match is rejected: the maps do not touch"), 0U) << r.err;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
  }
  EXPECT_EQ(mapFusion("match " + both() + " -q").err, "");
}

TEST_F(Messages, GiveTheReasonsAgainstThePoseFirst) {
  const auto r = mapFusion("match " + both() + apart());
  const size_t against = r.out.find("                 - the maps do not touch");
  ASSERT_NE(against, std::string::npos) << r.out;
  EXPECT_GT(r.out.find("                 + "), against) << r.out;
  EXPECT_FALSE(says(r.out, "slides")) << r.out;
}

TEST_F(Messages, HelpWithOutputsThatACommandDoesNotWrite) {
  expectLine("match " + both() + " -o fused.ot", 2, "--pose-out writes the pose; fuse and merge");
  expectLine("info " + pair("map_a.ot") + " --output x.ot", 2, "info has no option -o");
  expectLine("edges " + pair("map_a.ot") + " -o edges.ot", 2, ".ply or .gridmap");
  expectLine("pack " + both() + " -o team.bt", 2, ".rawlog");
  EXPECT_FALSE(fs::exists(dir_ / "edges.ot"));
}

TEST_F(Messages, NameTheFormatsOfMapsIfTheExtensionIsOfOtherFiles) {
  const std::string move = "transform " + pair("map_a.ot") + " --pose '[1 0 0 0 0 0]' -q -o ";
  for (const std::string unknown :
       {"moved.pcd", "moved.ot.gz", "moved.ply", "moved.ply.gz", "moved.rawlog"}) {
    expectLine(move + unknown, 2,
               unknown + ": transform writes maps: .ot or .bt of OctoMap, .grid");
    EXPECT_FALSE(fs::exists(dir_ / unknown));
  }
  expectLine("fuse " + both() + " -o fused.pcd", 2, "fused.pcd: fuse writes maps");
  expectLine("fuse " + both() + " -o fused.bt.gz", 2, "It does not pack octrees: gzip does");
  expectLine("edges " + pair("map_a.ot") + " -o edges.pcd", 2, ".ply or .gridmap");
  for (const std::string known :
       {"moved.ot", "moved.bt", "moved.gridmap", "moved.gz", "moved.gridmap.gz", "-", "/dev/null"})
    EXPECT_EQ(mapFusion(move + known).err, "") << known;
  for (const std::string unknown : {"moved", "moved.mrpt", "moved.v2.gz"}) {
    const auto r = mapFusion(move + unknown);
    EXPECT_EQ(r.code, 0);
    EXPECT_TRUE(says(r.err, unknown + ": is written as an object of MRPT")) << r.err;
  }
}

TEST_F(Messages, NameTheExtensionsOfDrawings) {
  const std::string match = "match " + both() + " -q ";
  for (const auto& [option, said] : std::vector<std::pair<std::string, std::string>>{
           {"--picture p.jpg", "p.jpg: a picture ends in .png"},
           {"--report p.txt", "p.txt: a page ends in .html"},
           {"--report p", "p: a page ends in .html"},
           {"--scene p.3ds", "p.3ds: a scene ends in .3Dscene"}}) {
    expectLine(match + option, 2, said);
    EXPECT_EQ(run("ls p.* p 2>/dev/null").out, "") << option;
  }
  EXPECT_EQ(mapFusion(match + "--picture /dev/null").code, 0) << "a device has no extension";
  const std::string capitals = "--picture P.PNG --report P.HTML --scene P.3DSCENE";
  EXPECT_EQ(mapFusion(match + capitals).code, 0) << "capitals do not matter";
  for (const std::string name : {"P.PNG", "P.HTML", "P.3DSCENE"})
    EXPECT_TRUE(fs::exists(dir_ / name)) << name;
}

TEST_F(Messages, SayWhatSeveralMapsHold) {
  fs::create_directory(dir_ / "b");
  fs::copy(pair("map_b.ot"), dir_ / "b/map_a.ot");
  const auto r = mapFusion("info " + pair("map_a.ot") + " b/map_a.ot");
  EXPECT_EQ(r.code, 0) << r.err;
  for (const std::string pair_of : {"map_a.ot", "map_b.ot"}) {
    const std::string one = mapFusion("info " + pair(pair_of)).out;
    const size_t figures = one.find(" 0.100 ");
    ASSERT_NE(figures, std::string::npos) << one;
    const std::string row = one.substr(figures, one.find('\n', figures) - figures);
    EXPECT_TRUE(says(r.out, row)) << r.out;
  }
  EXPECT_TRUE(says(r.out, "b_map_a")) << "files of one name have their folders\n" << r.out;
}

TEST_F(Messages, MisspeltSettingsNameTheNearest) {
  writeFile(dir_ / "c.ini", "[ProbabilisticMapMatching]\nserch_translation = 3\n");
  expectLine("match " + both() + " --config c.ini", 1,
             "has an unknown key 'serch_translation'; the nearest is 'search_translation'");
}

TEST_F(Messages, SayThatAnOptionHasNoEffect) {
  const std::string options = " --resolution 0.2 --sensor-origin '0 0 1'";
  const auto r = mapFusion("match " + both() + options);
  EXPECT_EQ(r.code, 0);
  for (const std::string option : {"--resolution", "--sensor-origin"}) {
    const size_t at = r.err.find(option + " has no effect: ");
    ASSERT_NE(at, std::string::npos) << r.err;
    EXPECT_EQ(r.err.find(option, at + 1), std::string::npos) << "once: " << r.err;
  }
  writeFile(dir_ / "c.ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
            "property float z\nend_header\n1 0 1\n");
  EXPECT_FALSE(says(mapFusion("info c.ply" + options).err, "no effect"));
  EXPECT_FALSE(says(mapFusion("transform " + pair("map_a.ot") +
                              " --resolution 0.5 --pose "
                              "'[0 0 0 0 0 0]' -o t.ot")
                        .err,
                    "no effect"));
}

TEST_F(Messages, SayThatMapsAreReadFromFiles) {
  expectLine("info -", 2, "from files, not from standard input");
  const std::string help = mapFusion("build --help").out;
  EXPECT_TRUE(says(help, "recording (.rawlog, .simplemap) or point cloud")) << help;
  EXPECT_FALSE(says(help, "maps: .ot")) << help;
}

TEST_F(Messages, SayWhatIsKnownOfOtherPosesThanAGivenPose) {
  const auto report = [&] { return nlohmann::json::parse(readFile(dir_ / "report.json")); };
  const std::string evaluate = "evaluate " + both() + " --json report.json --pose ";
  const auto wrong = mapFusion(evaluate + "\"[5 5 0 90 0 0]\"");
  EXPECT_EQ(wrong.code, 3);
  EXPECT_TRUE(says(wrong.out, "- another pose [")) << wrong.out;
  EXPECT_EQ(report()["match"]["other_poses"], "compared");
  EXPECT_GT(report()["match"]["runner_up"], 1);
  writeFile(dir_ / "no_search.ini", "[ProbabilisticMapMatching]\nsure_probability = 0\n");
  const auto right = mapFusion(evaluate + pair("T_a_b.txt") + " --config no_search.ini");
  EXPECT_TRUE(says(right.out, "other poses      were not searched")) << right.out;
  EXPECT_EQ(report()["match"]["other_poses"], "not_searched");
  EXPECT_TRUE(report()["match"]["runner_up"].is_null());
  EXPECT_TRUE(report()["match"]["rival_weight"].is_null());
}

TEST_F(Messages, OfWordsThatAreNoNumbersNameThem) {
  expectLine("match " + both() + " --threads 0", 2, "0 is not in [1, 1024]");
  expectLine("info " + pair("map_a.ot") + " --resolution 5cm", 2, "5cm is not a number");
  expectLine("build c.ply --sensor-origin 0 0 0 -o x.ot", 2,
             "three numbers need quotes: \"0 0 0\"");
}

TEST_F(Messages, HelpIsACommandToo) {
  EXPECT_EQ(mapFusion("help").out, mapFusion("--help").out);
  const auto of_fuse = mapFusion("help fuse");
  EXPECT_EQ(of_fuse.code, 0);
  EXPECT_EQ(of_fuse.out, mapFusion("fuse --help").out);
}

TEST_F(Messages, OfOneMapAreUsageErrors) {
  expectLine("fuse " + pair("map_a.ot") + " -o fused.ot", 2, "holds one map");
  expectLine("match " + pair("map_a.ot"), 2, "");
}

TEST_F(Messages, SayThatAFileThatIsGivenTwiceCountsOnce) {
  ASSERT_EQ(mapFusion("fuse " + both() + " -o once.ot").code, 0);
  const auto r = mapFusion("fuse " + both() + " " + pair("map_a.ot") + " -o fused.ot");
  EXPECT_EQ(r.code, 0);
  EXPECT_TRUE(says(r.err, "map_a.ot: is given twice, and counts once")) << r.err;
  EXPECT_TRUE(readFile(dir_ / "fused.ot") == readFile(dir_ / "once.ot"));
}

TEST_F(Messages, NameAllRobotsInTheSameWay) {
  for (const std::string folder : {"one", "two"}) {
    fs::create_directory(dir_ / folder);
    fs::copy(pair("map_a.ot"), dir_ / folder / "map_a.ot");
  }
  fs::copy(pair("map_b.ot"), dir_ / "two" / "map_b.ot");
  ASSERT_EQ(mapFusion("pack one/map_a.ot two/map_a.ot two/map_b.ot -o team.rawlog").code, 0);
  const std::string info = mapFusion("info team.rawlog").out;
  for (const std::string name : {"one_map_a", "two_map_a", "two_map_b"})
    EXPECT_TRUE(says(info, "  " + name + " ")) << info;
}

}  // namespace
