// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of settings and poses that come from a pipe. */

#include <sys/stat.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "run.h"

namespace {

class SettingsFromPipes : public AppTest {
 protected:
  void SetUp() override {
    AppTest::SetUp();
    ASSERT_EQ(::mkfifo((dir_ / "pipe").c_str(), 0600), 0);
  }

  /** Runs map-fusion with a file as the last argument. */
  Result fromFile(const std::string& arguments, const std::string& file) const {
    return mapFusion(arguments + " " + file);
  }
  /** Runs map-fusion with a named pipe instead of the file. */
  Result fromNamedPipe(const std::string& arguments, const std::string& file) const {
    return run("cat " + file + " > pipe & " MAP_FUSION " " + arguments +
               " pipe; code=$?; wait; exit $code");
  }
  /** Runs map-fusion with standard input instead of the file. */
  Result fromStandardInput(const std::string& arguments, const std::string& file) const {
    return run("cat " + file + " | " MAP_FUSION " " + arguments + " /dev/stdin");
  }

  nlohmann::json takeReport() const {
    const auto report = nlohmann::json::parse(readFile(dir_ / "report.json"));
    fs::remove(dir_ / "report.json");
    return report;
  }
};

TEST_F(SettingsFromPipes, OfAMatchAreThoseOfTheFile) {
  writeFile(dir_ / "settings.ini",
            "[ProbabilisticMapMatching]\nvoxel_spacing = 0.4\nsearch_hypotheses = 3\n");
  const std::string match =
      "match -q " + both() + " --init " + guess(0.3, 3) + " --pose-out T.txt --config";
  ASSERT_EQ(fromFile(match, "settings.ini").code, 0);
  const std::string pose = readFile(dir_ / "T.txt");
  ASSERT_EQ(mapFusion("match -q " + both() + " --init guess.txt --pose-out T.txt").code, 0);
  ASSERT_NE(readFile(dir_ / "T.txt"), pose) << "the settings have no effect";

  fs::remove(dir_ / "T.txt");
  const auto named = fromNamedPipe(match, "settings.ini");
  EXPECT_EQ(named.code, 0) << named.err;
  EXPECT_EQ(readFile(dir_ / "T.txt"), pose);

  fs::remove(dir_ / "T.txt");
  const auto input = fromStandardInput(match, "settings.ini");
  EXPECT_EQ(input.code, 0) << input.err;
  EXPECT_EQ(readFile(dir_ / "T.txt"), pose);
}

TEST_F(SettingsFromPipes, OfAMapAreThoseOfTheFile) {
  writeFile(dir_ / "map.ini",
            "[MappingApplication]\nprobOctoMap_count = 1\n"
            "[MappingApplication_probOctoMap_00_creationOpts]\nresolution = 0.25\n"
            "[ProbabilisticMapMatching]\nkappa = 0.5\n");
  const std::string build =
      "build -q " + pair("robot_a.rawlog") + " -o map.ot --json report.json --config";
  for (const auto& r : {fromNamedPipe(build, "map.ini"), fromStandardInput(build, "map.ini")})
    EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_EQ(takeReport().at("maps").at(0).at("resolution_m"), 0.25);
}

TEST_F(SettingsFromPipes, AreChecked) {
  writeFile(dir_ / "range.ini", "[ProbabilisticMapMatching]\nkappa = 5\n");
  writeFile(dir_ / "empty.ini", "");
  for (const auto& [file, part] :
       {std::pair("range.ini", "kappa = 5"), std::pair("empty.ini", "is empty")})
    for (const auto& r : {fromNamedPipe("match " + both() + " --config", file),
                          fromStandardInput("match " + both() + " --config", file)}) {
      EXPECT_EQ(r.code, 1) << file;
      EXPECT_NE(r.err.find(part), std::string::npos) << r.err;
      EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
    }
}

TEST_F(SettingsFromPipes, WithoutEndAreOneLine) {
  if (!fs::is_character_file("/dev/zero")) GTEST_SKIP() << "/dev/zero is no device";
  for (const std::string option : {" --config ", " --init "}) {
    const auto r = mapFusion("match " + both() + option + "/dev/zero");
    EXPECT_EQ(r.code, 1) << option;
    EXPECT_NE(r.err.find("/dev/zero: has more than"), std::string::npos) << r.err;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
  }
}

TEST_F(SettingsFromPipes, APoseMayComeFromAPipe) {
  const std::string transform = "transform -q " + pair("map_a.ot") + " -o moved.ot --pose";
  ASSERT_EQ(fromFile(transform, pair("T_a_b.txt")).code, 0);
  const std::string moved = readFile(dir_ / "moved.ot");
  fs::remove(dir_ / "moved.ot");
  EXPECT_EQ(fromNamedPipe(transform, pair("T_a_b.txt")).code, 0);
  EXPECT_TRUE(readFile(dir_ / "moved.ot") == moved);
  fs::remove(dir_ / "moved.ot");
  EXPECT_EQ(fromStandardInput(transform, pair("T_a_b.txt")).code, 0);
  EXPECT_TRUE(readFile(dir_ / "moved.ot") == moved);
}

TEST_F(SettingsFromPipes, AMapIsReadFromAFile) {
  for (const auto& r :
       {fromStandardInput("info", pair("map_a.ot")), mapFusion("info pipe"),
        mapFusion("match " + pair("map_a.ot") + " pipe"), mapFusion("info /dev/null")}) {
    EXPECT_EQ(r.code, 1);
    EXPECT_NE(r.err.find("is a pipe or a device"), std::string::npos) << r.err;
  }
}

}  // namespace
