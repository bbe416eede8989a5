// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the page and its data. */

#include "fusion_report/page/page.h"

#include <gtest/gtest.h>
#include <mrpt/fusion/poses.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "fusion_report/json.h"
#include "fusion_report/page/covariance.h"
#include "fusion_report/page/graph.h"
#include "support/tree_tools.h"

using namespace mrpt::fusion;
using namespace map_tests;
using Json = nlohmann::ordered_json;

namespace {

const std::string kHostile =
    "</script><script>alert(1)</script><!-- \"'&amp; \x01\x1b[31m \u202e \u2028 \xff";

/** Returns the text of a block of data. */
std::string blockOf(const std::string& page, const std::string& id) {
  const std::string start = "<script type=\"application/json\" id=\"" + id + "\">";
  const size_t from = page.find(start);
  EXPECT_NE(from, std::string::npos) << id;
  const size_t begin = from + start.size();
  return page.substr(begin, page.find("</script>", begin) - begin);
}

size_t countOf(const std::string& text, const std::string& part) {
  size_t n = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) n++;
  return n;
}

PageMap mapOf(const std::string& name, unsigned seed) {
  PageMap map;
  map.name = name;
  map.octree = sceneTree(0.1, seed);
  return map;
}

/** A judged pair with a rival, and with names from outside. */
struct PairPage {
  Report report;
  PageScene scene;

  PairPage() {
    report.command = "match";
    scene.kind = PageScene::Kind::Pair;
    scene.maps = {mapOf("A", 1), mapOf("B", 2)};
    scene.maps[1].pose.translation() = Eigen::Vector3d(0.5, 0.25, 0);
    for (const PageMap& map : scene.maps)
      report.maps.push_back(reportOn(map.name, kHostile, *map.octree));
    report.notes = {kHostile};
    report.pose.emplace().mean = toPose(scene.maps[1].pose);
    report.pose->cov.setIdentity();
    report.pose->cov *= 1e-4;
    Alignment& match = report.match.emplace();
    match.evaluation.accepted = true;
    match.evaluation.overlap = 1.0 / 3;
    match.evaluation.reasons = {kHostile};
    match.match.hypotheses.resize(3);
    for (auto& h : match.match.hypotheses) h.T_a_b = scene.maps[1].pose;
    match.match.hypotheses[0].agreement = 80;
    match.match.hypotheses[1].agreement = 20;
    match.match.hypotheses[1].T_a_b.translation().x() = 7;
    match.match.hypotheses[2].agreement = 1e-3;
    match.match.pairs = {{0, 0, 0.0F}, {1, 1, 4.0F}, {4000000000U, 2, 0.0F}};
    report.seconds = {{"load", 0.1}, {"match", 1.0 / 7}};
  }
  Json data() const { return Json::parse(toSceneJson(report, scene)); }
  std::string page() const { return toPage(report, toSceneJson(report, scene)); }
};

TEST(Page, HoldsTheNumbersOfTheJson) {
  const PairPage pair;
  EXPECT_EQ(Json::parse(blockOf(pair.page(), "report")), Json::parse(toJson(pair.report)));
  EXPECT_EQ(Json::parse(blockOf(pair.page(), "scene")), pair.data());
}

TEST(Page, IsNotChangedByNamesAndPaths) {
  PairPage pair;
  const std::string before = pair.page();
  pair.scene.maps[0].name = kHostile;
  const std::string page = pair.page();
  EXPECT_EQ(countOf(page, "</script>"), 3U);  // report, scene, script
  EXPECT_EQ(countOf(page, "</script"), 3U);
  EXPECT_EQ(countOf(page, "<!--"), countOf(before, "<!--"));
  for (const char* id : {"report", "scene"}) {
    const std::string block = blockOf(page, id);
    for (const char c : block) {
      EXPECT_EQ(std::string("<>&").find(c), std::string::npos);
      EXPECT_TRUE(static_cast<unsigned char>(c) >= 0x20 || c == '\n') << static_cast<int>(c);
    }
  }
  // All that is not data is as it was built.
  EXPECT_EQ(page.substr(0, page.find("<script type=")),
            before.substr(0, before.find("<script type=")));
  EXPECT_EQ(page.substr(page.rfind("<script>")), before.substr(before.rfind("<script>")));
}

TEST(Page, LoadsNothing) {
  const std::string page = PairPage().page();
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
  EXPECT_EQ(page.find("script-src 'unsafe"), std::string::npos);
  for (const char* attribute :
       {" src=\"", " src='", "url(http", "@import", "<link rel=\"stylesheet"})
    EXPECT_EQ(page.find(attribute), std::string::npos) << attribute;
}

TEST(Page, KeepsTheLicenseOfThree) {
  EXPECT_NE(PairPage().page().find("three.js authors"), std::string::npos);
}

TEST(Page, IsKnownByItsBeginning) {
  EXPECT_TRUE(isPage(PairPage().page().substr(0, 64)));
  EXPECT_FALSE(isPage("<!doctype html>\n<html><body>"));
  EXPECT_FALSE(isPage(""));
}

TEST(Page, IsSmall) {
  const PairPage pair;
  const std::string empty = toPage(pair.report, "{}");
  EXPECT_LT(empty.size(), 700'000U);
  octomap::OcTree large(0.1);
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> value(0.1F, 3.5F);
  for (int x = 0; x < 320; x++)
    for (int y = 0; y < 320; y++) putVoxel(large, {x, y, x / 20}, value(rng));
  PageScene scene;
  scene.maps = {mapOf("map", 1)};
  scene.maps[0].octree = std::make_shared<const octomap::OcTree>(large);
  const std::string json = toSceneJson({}, scene);
  EXPECT_LT(json.size(), 5U * 320 * 320 / 2);
  EXPECT_EQ(Json::parse(json)["maps"][0]["count"], 320 * 320);
}

TEST(PageScene, HasTheRivalsThatAgree) {
  const Json rivals = PairPage().data()["rivals"];
  ASSERT_EQ(rivals.size(), 1U);
  EXPECT_EQ(rivals[0]["map"], 1);
  EXPECT_EQ(rivals[0]["rank"], 1);
  EXPECT_EQ(rivals[0]["agreement"], 0.25);
  EXPECT_EQ(rivals[0]["pose"][3], 7);
}

TEST(PageScene, HasThePairsThatLieInTheMaps) {
  const Json pairs = PairPage().data()["pairs"];
  EXPECT_EQ(pairs["count"], 3);
  EXPECT_EQ(pairs["inliers"].get<std::string>().size(), 16U);  // 12 bytes
  EXPECT_EQ(pairs["outliers"].get<std::string>().size(), 16U);
}

TEST(PageScene, HidesWhatDoesNotApply) {
  PageScene scene;
  scene.maps = {mapOf("map", 1)};
  const Json json = Json::parse(toSceneJson({}, scene));
  EXPECT_EQ(json["kind"], "maps");
  EXPECT_TRUE(json["rivals"].empty());
  EXPECT_TRUE(json["graph"]["nodes"].empty());
  EXPECT_FALSE(json.contains("pairs"));
  EXPECT_FALSE(json.contains("fused"));
  EXPECT_FALSE(json["maps"][0].contains("conflicts"));
  EXPECT_TRUE(json["maps"][0].contains("free"));
}

TEST(PageScene, TakesMapsWithoutVoxels) {
  PageScene scene;
  scene.maps = {mapOf("map", 1)};
  scene.maps[0].octree = std::make_shared<const octomap::OcTree>(0.1);
  EXPECT_EQ(Json::parse(toSceneJson({}, scene))["maps"][0]["count"], 0);
}

TEST(PageScene, ShowsATeamAsAGraph) {
  Report report;
  PageScene scene;
  scene.kind = PageScene::Kind::Team;
  for (const char* name : {"r0", "r1", "r2"}) {
    scene.maps.push_back(mapOf(name, 1));
    auto& member = report.members.emplace_back();
    member.robot = name;
    member.alignment.voxels_b = scene.maps.size() > 1 ? 100 : 0;
    member.matched_with = scene.maps.size() > 1 ? "r0" : "";
    member.joined = true;
    member.pose.cov.setZero();
    if (scene.maps.size() > 1) member.pose.cov(0, 0) = 0.01 * 0.01;
  }
  scene.maps[2].pose.translation().x() = 3;
  report.pairs = {{"r0", "r1", true, false, 0.99, 0.5, true},
                  {"r0", "r2", false, true, 0.5, 0.5, true},
                  {"r1", "r2", true, false, 0.9, 0.4, false}};
  const TeamPicture picture = pictureOf(report, scene);
  ASSERT_EQ(picture.nodes.size(), 3U);
  ASSERT_EQ(picture.links.size(), 3U);
  EXPECT_EQ(picture.links[0].verdict, "sure");
  EXPECT_EQ(picture.links[1].verdict, "held");
  EXPECT_EQ(picture.links[2].verdict, "refuted");
  EXPECT_EQ(picture.links[2].a, 1U);
  EXPECT_EQ(picture.links[2].b, 2U);
  EXPECT_NEAR(picture.nodes[2].at.x() - picture.nodes[1].at.x(), 3, 1e-9);
  // The ellipsoid is 3 standard deviations long, times the factor that the page tells.
  EXPECT_FALSE(picture.nodes[0].half_axes);
  ASSERT_TRUE(picture.nodes[1].half_axes);
  EXPECT_GT(picture.enlarged, 1);
  EXPECT_NEAR(picture.nodes[1].half_axes->norm(), 0.03 * picture.enlarged, 1e-9);
}

TEST(PageScene, CutsTheEllipsoidOfAMapThatSlides) {
  PairPage pair;
  pair.report.pose->cov(0, 0) = kUnknownVariance;
  const TeamPicture picture = pictureOf(pair.report, pair.scene);
  ASSERT_EQ(picture.nodes.size(), 1U);
  ASSERT_TRUE(picture.nodes[0].half_axes);
  EXPECT_LT(picture.nodes[0].half_axes->norm(), 10);
  EXPECT_GT(picture.nodes[0].half_axes->norm(), 1);
}

TEST(CovarianceOfAPoint, GrowsWithTheLeverOfTheRotation) {
  mrpt::poses::CPose3DPDFGaussian pose;
  pose.mean.setFromValues(5, -2, 1, 0, 0, 0);
  pose.cov.setZero();
  pose.cov(2, 2) = 0.04;
  pose.cov(3, 3) = 1e-4;  // yaw
  const Eigen::Matrix3d at_origin = covarianceOf(pose, {0, 0, 0}),
                        far = covarianceOf(pose, {10, 0, 0});
  EXPECT_NEAR(at_origin(1, 1), 0, 1e-12);
  EXPECT_NEAR(far(1, 1), 1e-4 * 100, 1e-9);
  EXPECT_NEAR(far(0, 0), 0, 1e-12);
  EXPECT_NEAR(far(2, 2), 0.04, 1e-12);
  const Eigen::Matrix3d axes = ellipsoidOf(far);
  EXPECT_NEAR(axes.col(2).norm(), 3 * 0.2, 1e-9);
  EXPECT_NEAR(std::abs(axes(2, 2)), 3 * 0.2, 1e-9);
}

}  // namespace
