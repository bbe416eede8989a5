// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of bad input: message, exit code and no output. */

#include <octomap/octomap.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "run.h"

namespace {

/** Each failure prints one line on stderr that names the culprit, returns the documented exit code,
 * and leaves no output. */
class BadInput : public AppTest {
 protected:
  void expectFailure(const std::string& arguments, const std::string& culprit, int code = 1) const {
    const auto r = mapFusion(arguments);
    EXPECT_EQ(r.code, code) << arguments << "\n" << r.err;
    EXPECT_NE(r.err.find(culprit), std::string::npos) << arguments << "\n" << r.err;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << arguments << "\n" << r.err;
    EXPECT_EQ(r.out, "") << arguments;
    for (const auto& entry : fs::directory_iterator(dir_))
      EXPECT_EQ(entry.path().filename().string().rfind("out", 0), std::string::npos)
          << arguments << " left " << entry.path();
  }
};

TEST_F(BadInput, FilesThatAreNoMaps) {
  const std::string good = pair("map_a.ot");
  writeFile(dir_ / "empty.ot", "");
  writeFile(dir_ / "text.ot", "This is not a map.\n");
  writeFile(dir_ / "truncated.ot", readFile(good).substr(0, 100'000));
  writeFile(dir_ / "truncated.rawlog", readFile(pair("robot_a.rawlog")).substr(0, 100'000));
  fs::create_directory(dir_ / "folder");
  octomap::OcTree free_only(0.1);
  free_only.updateNode(0.05, 0.05, 0.05, false);
  free_only.write((dir_ / "no_obstacles.ot").string());
  octomap::OcTree(0.1).write((dir_ / "no_voxels.ot").string());

  for (const std::string bad : {"missing.ot", "empty.ot", "text.ot", "truncated.ot",
                                "truncated.rawlog", "folder", "no_obstacles.ot", "no_voxels.ot"}) {
    expectFailure("fuse " + bad + " " + good + " -o out.ot --json out.json", bad);
    expectFailure("fuse " + good + " " + bad + " -o out.ot --json out.json", bad);
    expectFailure("edges " + bad + " -o out.ply", bad);
  }
}

TEST_F(BadInput, PosesThatAreNone) {
  writeFile(dir_ / "scaled.txt", "2 0 0 0  0 2 0 0  0 0 2 0  0 0 0 1\n");
  writeFile(dir_ / "mirror.txt", "-1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1\n");
  writeFile(dir_ / "short.txt", "1 0 0 0  0 1 0 0\n");
  writeFile(dir_ / "nan.txt", "1 0 0 nan  0 1 0 0  0 0 1 0  0 0 0 1\n");
  writeFile(dir_ / "words.txt", "the pose of the second robot\n");
  for (const std::string bad : {"scaled.txt", "mirror.txt", "short.txt", "nan.txt", "words.txt",
                                "missing.txt", "\"[1 2 3]\"", "\"[1 2 3 4 5 x]\"",
                                "\"[1 2 3 4 5 6\"", "\"[1 2 3 4 5 inf]\"", "\"[1 2 3 4 5 6 7]\""}) {
    const std::string culprit = bad.substr(bad[0] == '"' ? 1 : 0, 6);
    expectFailure("match " + both() + " --init " + bad + " --pose-out out.txt", culprit);
    expectFailure("merge " + both() + " --pose " + bad + " -o out.ot", culprit);
  }
}

TEST_F(BadInput, GuessesFartherThanTheMapsReach) {
  for (const std::string pose : {"\"[1e9 0 0 0 0 0]\"", "\"[0 -1e18 0 0 0 0]\"",
                                 "\"[0 0 1e5 0 0 0]\"", "\"[1e300 0 0 0 0 0]\""}) {
    expectFailure("match " + both() + " --init " + pose, "guess");
    expectFailure("match " + both() + " --init " + pose + " --init-sigma 1e5 6", "guess");
    expectFailure("evaluate " + both() + " --pose " + pose, "pose");
    expectFailure("merge " + both() + " --pose " + pose + " -o out.ot", "does not fit");
  }
}

TEST_F(BadInput, MapsOfFewNodesThatTakeTooMuchWork) {
  for (const bool occupied : {false, true}) {
    octomap::OcTree tree(0.1);
    for (int i = 0; i < 8; i++) {  // so that no 8 siblings are equal
      const float at = 0.05F + 0.1F * static_cast<float>(i);
      tree.updateNode(octomap::point3d(at, 0.05F, 0.05F), true);
    }
    auto* node = tree.getRoot();
    for (unsigned depth = 0; depth < 5; depth++) {
      const unsigned child = depth == 0 ? 0 : 7;
      if (!tree.nodeChildExists(node, child)) tree.createNodeChild(node, child);
      node = tree.getNodeChild(node, child);
    }
    node->setLogOdds(occupied ? 1.5F : -1.5F);
    tree.write((dir_ / "coarse.ot").string());
    const std::string pose = " --pose \"[3.3 -1.2 0.4 30 0 0]\" -o out.ot";
    expectFailure("transform coarse.ot" + pose, "few nodes");
    expectFailure("merge " + pair("map_a.ot") + " coarse.ot" + pose, "few nodes");
    if (occupied) expectFailure("edges coarse.ot -o out.ply", "coarse.ot");
  }
}

TEST_F(BadInput, OutputsThatCannotBeWritten) {
  fs::create_directory(dir_ / "folder");
  const std::string to = "merge " + both() + " --pose " + pair("T_a_b.txt") + " -o ";
  expectFailure(to + "no/such/folder/fused.ot", "no/such/folder");
  expectFailure(to + "folder", "folder");
  expectFailure(to + "/dev/full", "/dev/full");
  expectFailure("match " + both() + " --pose-out no/such/T.txt", "no/such");
}

TEST_F(BadInput, SettingsThatAreWrong) {
  writeFile(dir_ / "typo.ini", "[ProbabilisticMapMatching]\nkapa = 0.5\n");
  writeFile(dir_ / "range.ini", "[ProbabilisticMapMatching]\nkappa = 5\n");
  writeFile(dir_ / "word.ini", "[ProbabilisticMapMatching]\nkappa = much\n");
  writeFile(dir_ / "other.ini", "[SomethingElse]\nkappa = 0.5\n");
  const std::string match = "match " + both() + " --config ";
  expectFailure(match + "typo.ini", "kapa");
  expectFailure(match + "range.ini", "kappa = 5");
  expectFailure(match + "word.ini", "kappa = much");
  expectFailure(match + "other.ini", "other.ini");
  expectFailure(match + "missing.ini", "missing.ini");
}

TEST_F(BadInput, WrongUsageIsExitCode2) {
  for (const std::string wrong :
       {"", "frobnicate", "match one.ot", "fuse a.ot b.ot", "info --what a.ot",
        "merge a.ot b.ot -o c.ot", "transform a.ot -o b.ot",
        "fuse a.ot b.ot -o c.ot --policy guess", "match a.ot b.ot --threads 0"}) {
    const auto r = mapFusion(wrong);
    EXPECT_EQ(r.code, 2) << wrong;
    EXPECT_NE(r.err, "") << wrong;
  }
}

TEST_F(BadInput, PosesThatAreAlmostRightSayWhatIsMissing) {
  for (const auto& [pose, said] : std::vector<std::pair<std::string, std::string>>{
           {"'1 2 3 4 5 6'", "six numbers need [ ]"},
           {"'[1, 2, 3, 4, 5, 6]'", "blanks separate the numbers, not commas"},
           {"'[1,2,3,4,5,6]'", "blanks separate the numbers, not commas"},
           {pair("map_b.ot"), "is a map, not a pose"}})
    expectFailure("match " + both() + " --init " + pose, said);
}

TEST_F(BadInput, AnUnknownOptionNamesTheNearest) {
  for (const auto& [given, said] : std::vector<std::pair<std::string, std::string>>{
           {"match a.ot b.ot --pitcure p.png",
            "match has no option --pitcure; the nearest is --picture"},
           {"fuse a.ot b.ot -o c.ot --jsn f", "fuse has no option --jsn; the nearest is --json"},
           {"info a.ot --frobnicate", "info has no option --frobnicate"},
           {"match a.ot b.ot \"--pi$(printf '\\033')cture\"", "the nearest is --picture"}}) {
    const auto r = mapFusion(given);
    EXPECT_EQ(r.code, 2) << given;
    EXPECT_NE(r.err.find(said), std::string::npos) << r.err;
    EXPECT_EQ(r.err.find('\x1b'), std::string::npos);
  }
}

TEST_F(BadInput, AFileInPlaceOfACommandSaysThatACommandIsMissing) {
  writeFile(dir_ / "here.ot", "x");
  const auto r = mapFusion("here.ot b.ot");
  EXPECT_EQ(r.code, 2);
  EXPECT_NE(r.err.find("is a file; a command comes first"), std::string::npos) << r.err;
}

TEST_F(BadInput, AnUnknownCommandNamesTheNearest) {
  for (const auto& [word, nearest] :
       std::vector<std::pair<std::string, std::string>>{{"matc", "match"},
                                                        {"Match", "match"},
                                                        {"fues", "fuse"},
                                                        {"mrege", "merge"},
                                                        {"evalute", "evaluate"},
                                                        {"transfrom", "transform"},
                                                        {"inf", "info"},
                                                        {"bild", "build"},
                                                        {"unpack", "pack"},
                                                        {"edge", "edges"}}) {
    const auto r = mapFusion(word + " a b");
    EXPECT_EQ(r.code, 2) << word;
    EXPECT_EQ(r.out, "") << word;
    EXPECT_NE(r.err.find("no command '" + word + "'; the nearest is '" + nearest + "'"),
              std::string::npos)
        << r.err;
  }
  const auto r = mapFusion("\"$(printf 'm\\033[2J\\377atch')\" a b");
  EXPECT_EQ(r.code, 2);
  EXPECT_EQ(r.err.find('\x1b'), std::string::npos);
  EXPECT_EQ(r.err.find('\xff'), std::string::npos);
  EXPECT_LT(mapFusion(std::string(5000, 'm')).err.size(), 500U);
}

}  // namespace
