// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the report, its text and its JSON. */

#include "fusion_report/report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>

#include "fusion_report/json.h"
#include "fusion_report/text.h"

using namespace mrpt::fusion;
using Json = nlohmann::ordered_json;

namespace {

/** A map of one occupied and one free voxel. */
octomap::OcTree smallMap() {
  octomap::OcTree map(0.1);
  map.updateNode(0.05, 0.05, 0.05, true);
  map.updateNode(0.45, 0.05, 0.25, false);
  return map;
}

/** A rejected match with one rival. */
Alignment rejectedMatch() {
  Alignment match;
  match.evaluation.accepted = false;
  match.evaluation.is_ambiguous = true;
  match.evaluation.addReasonFor("overlap 50.0 % is sufficient");
  match.evaluation.addReasonAgainst("another pose fits as well");
  match.evaluation.addReasonFor("the obstacles agree");
  match.evaluation.addReasonAgainst("the pose is not held");
  match.evaluation.sampled = 200;
  match.evaluation.pairs = 100;
  match.evaluation.inliers = 50;
  match.evaluation.overlap = 0.5;
  match.voxels_a = 10;
  match.voxels_b = 20;
  match.match.hypotheses.resize(2);
  match.match.hypotheses[1].T_a_b.translation().x() = 7;
  return match;
}

std::string textOf(const Report& report) {
  std::ostringstream text;
  print(report, text);
  return text.str();
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Report, HoldsTheFiguresOfAMap) {
  const auto m = reportOn("a", "a.ot", smallMap());
  EXPECT_EQ(m.role, "a");
  EXPECT_EQ(m.path, "a.ot");
  EXPECT_EQ(m.resolution, 0.1);
  EXPECT_EQ(m.nodes, smallMap().size());
  EXPECT_EQ(m.statistics.occupied, 1U);
  EXPECT_EQ(m.statistics.free, 1U);
  const double low[3] = {0, 0, 0}, high[3] = {0.5, 0.1, 0.3};
  for (int axis = 0; axis < 3; axis++) {
    EXPECT_NEAR(m.low[axis], low[axis], 1e-9) << axis;
    EXPECT_NEAR(m.high[axis], high[axis], 1e-9) << axis;
  }
}

TEST(Report, TakesAnEmptyMap) {
  const auto m = reportOn("a", "a.ot", octomap::OcTree(0.1));
  EXPECT_EQ(m.nodes, 0U);
  EXPECT_EQ(m.low[0], 0);
  EXPECT_EQ(m.high[0], 0);
}

TEST(ReportAsText, HoldsOnlyWhatTheRunFound) {
  Report report;
  report.command = "info";
  report.maps.push_back(reportOn("map", "a.ot", smallMap()));
  report.seconds = {{"load", 0.5}, {"save", 0.25}};
  const std::string text = textOf(report);
  EXPECT_TRUE(contains(text, "  map            0.100          1          1")) << text;
  EXPECT_TRUE(contains(text, "0.5 x 0.1 x 0.3")) << text;
  EXPECT_TRUE(contains(text, "load 0.50, save 0.25, total 0.75")) << text;
  for (const char* part : {"pose", "verdict", "merged", "written", "observations"})
    EXPECT_FALSE(contains(text, part)) << part << "\n" << text;
}

TEST(ReportAsText, HoldsTheVerdictWithItsReasons) {
  Report report;
  report.pose.emplace().mean = mrpt::poses::CPose3D(1, 2, 3, 0, 0, 0);
  report.match = rejectedMatch();
  report.policy = "bayes";
  const std::string text = textOf(report);
  EXPECT_TRUE(contains(text, "[1.0000 2.0000 3.0000 0.000 0.000 0.000]")) << text;
  EXPECT_TRUE(contains(text, "AMBIGUOUS")) << text;
  const std::string reasons =
      "                 - another pose fits as well\n"
      "                 - the pose is not held\n"
      "                 + overlap 50.0 % is sufficient\n"
      "                 + the obstacles agree\n";
  EXPECT_TRUE(contains(text, reasons)) << text;
  EXPECT_TRUE(contains(text, "[7.0000 0.0000 0.0000")) << "the rival: " << text;
  EXPECT_TRUE(contains(text, "50.0 %")) << text;
  EXPECT_TRUE(contains(text, "bayes")) << text;
}

TEST(ReportAsJson, HoldsTheSameFiguresUnderDocumentedKeys) {
  Report report;
  report.command = "match";
  report.maps.push_back(reportOn("a", "a.ot", smallMap()));
  report.pose.emplace().mean = mrpt::poses::CPose3D(1, 2, 3, mrpt::DEG2RAD(90.0), 0, 0);
  report.pose->cov(0, 0) = 0.25;
  report.match = rejectedMatch();
  report.observations = {5, 2, {{"CObservationImage", "no map takes it", 2}}};
  report.seconds = {{"load", 0.5}};
  const Json j = Json::parse(toJson(report));
  EXPECT_EQ(j.at("command"), "match");
  EXPECT_EQ(j.at("maps").at(0).at("occupied_voxels"), 1);
  EXPECT_EQ(j.at("maps").at(0).at("resolution_m"), 0.1);
  EXPECT_NEAR(j.at("pose").at("yaw_deg"), 90, 1e-9);
  EXPECT_NEAR(j.at("pose").at("matrix")[1][0], 1, 1e-9);
  EXPECT_EQ(j.at("pose").at("matrix")[2][3], 3);
  EXPECT_EQ(j.at("pose").at("covariance")[0][0], 0.25);
  EXPECT_FALSE(j.at("match").at("accepted"));
  EXPECT_TRUE(j.at("match").at("ambiguous"));
  EXPECT_EQ(j.at("match").at("reasons").at(0), "another pose fits as well");
  EXPECT_EQ(j.at("match").at("reasons").at(3), "the obstacles agree");
  EXPECT_EQ(j.at("match").at("reasons_against"), 2);
  EXPECT_EQ(j.at("match").at("hypotheses").at(1).at("pose").at("x"), 7);
  EXPECT_EQ(j.at("match").at("voxels_b"), 20);
  EXPECT_EQ(j.at("observations").at("inserted"), 5);
  EXPECT_EQ(j.at("observations").at("ignored"), 2);
  const Json& left_out = j.at("observations").at("left_out").at(0);
  EXPECT_EQ(left_out.at("kind"), "CObservationImage");
  EXPECT_EQ(left_out.at("reason"), "no map takes it");
  EXPECT_EQ(left_out.at("count"), 2);
  EXPECT_TRUE(contains(textOf(report), "- 2 CObservationImage: no map takes it\n"));
  EXPECT_EQ(j.at("seconds").at("load"), 0.5);
  for (const char* key : {"initial_pose", "robots", "bytes", "policy", "edge_voxels"})
    EXPECT_FALSE(j.contains(key)) << key;
}

TEST(ReportAsJson, HoldsTheRobotsOfATeam) {
  Report report;
  report.members.resize(2);
  report.members[0].robot = "first";
  report.members[0].joined = true;
  report.members[1].robot = "second";
  report.members[1].alignment = rejectedMatch();
  const Json robots = Json::parse(toJson(report)).at("robots");
  ASSERT_EQ(robots.size(), 2U);
  EXPECT_EQ(robots[0].at("robot"), "first");
  EXPECT_TRUE(robots[0].at("joined"));
  EXPECT_FALSE(robots[0].contains("match")) << "the others are matched with the first map";
  EXPECT_EQ(robots[0].at("pose").at("matrix"),
            Json::parse("[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]"));
  EXPECT_TRUE(robots[0].at("probability").is_null()) << "its pose is given, not found";
  EXPECT_FALSE(robots[0].contains("covariance"));
  EXPECT_FALSE(robots[1].at("joined"));
  EXPECT_EQ(robots[1].at("match").at("pairs"), 100);
  EXPECT_EQ(robots[1].at("covariance"), robots[1].at("pose").at("covariance"));
  EXPECT_EQ(robots[1].at("covariance").size(), 6U);
  EXPECT_EQ(robots[1].at("probability"), robots[1].at("match").at("probability"));
}

TEST(ReportAsText, KeepsItsColumnsWhateverTheNames) {
  Report report;
  report.members.resize(3);
  for (const std::string name : {"short", "a_robot_with_a_long_name", "caf\xc3\xa9\x01"}) {
    report.maps.push_back(reportOn(name, name + ".ot", smallMap()));
    report.members[report.maps.size() - 1].robot = name;
  }
  std::istringstream lines(textOf(report));
  std::set<size_t> columns, of_members;
  for (std::string line; std::getline(lines, line);) {
    // A character of two bytes is in one column, an escaped character in four.
    if (const size_t two = line.find("\xc3\xa9"); two != std::string::npos)
      line.replace(two, 2, "e");
    if (const size_t at = line.find("0.100"); at != std::string::npos) columns.insert(at);
    if (const size_t at = line.find("first map"); at != std::string::npos) of_members.insert(at);
  }
  EXPECT_EQ(columns.size(), 1U) << textOf(report);
  EXPECT_EQ(of_members.size(), 1U) << textOf(report);
}

TEST(ReportAsJson, EscapesPathsOfAnyBytes) {
  Report report;
  const std::string odd = "a \"quoted\"\\ name\nin two lines\t\x01.ot";
  report.maps.push_back(reportOn("a", odd, smallMap()));
  report.maps.push_back(reportOn("b", "caf\xe9.ot", smallMap()));       // Latin-1
  report.maps.push_back(reportOn("c", "caf\xc3\xa9.ot", smallMap()));   // UTF-8
  report.maps.push_back(reportOn("d", "\xff\xfe\x80.ot", smallMap()));  // no encoding
  const Json maps = Json::parse(toJson(report)).at("maps");
  EXPECT_EQ(maps.at(0).at("path"), odd);
  EXPECT_EQ(maps.at(1).at("path"), "caf\xef\xbf\xbd.ot") << "U+FFFD";
  EXPECT_EQ(maps.at(2).at("path"), "caf\xc3\xa9.ot");
  EXPECT_EQ(maps.at(3).at("path"), "\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd.ot");
}

}  // namespace
