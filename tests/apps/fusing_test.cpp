// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the commands on two maps. */

#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/opengl/COpenGLScene.h>
#include <mrpt/opengl/CSetOfLines.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <octomap/octomap.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "run.h"

using Json = nlohmann::json;

namespace {

class Fusing : public AppTest {
 protected:

  static Json mapOf(const Json& report, const std::string& role) {
    for (const auto& m : report.at("maps"))
      if (m.at("role") == role) return m;
    return {};
  }

  void expectNearTruth(const fs::path& pose_file) const {
    const Eigen::Isometry3d truth = readMatrix(pair("T_a_b.txt"));
    const Eigen::Isometry3d T = readMatrix(pose_file);
    EXPECT_LT((T.translation() - truth.translation()).norm(), 0.1);
    const double angle = Eigen::AngleAxisd(T.linear() * truth.linear().transpose()).angle();
    EXPECT_LT(angle * 180 / M_PI, 1.0);
  }
};

TEST_F(Fusing, TwoRobotsMapsOfARealBuildingFromAGuess1mAnd10degOff) {
  const auto r = mapFusion("fuse " + both() + " --init " + guess(1, 10) +
                           " -o fused.ot --pose-out T.txt --picture view.png --json report.json");
  ASSERT_EQ(r.code, 0) << r.err;
  EXPECT_NE(r.out.find("accepted"), std::string::npos);
  expectNearTruth(dir_ / "T.txt");

  const std::unique_ptr<octomap::AbstractOcTree> fused(
      octomap::AbstractOcTree::read((dir_ / "fused.ot").string()));
  ASSERT_NE(fused, nullptr) << "OctoMap's own reader opens the fused map";

  const Json j = report();
  EXPECT_EQ(fused->size(), mapOf(j, "fused").at("nodes"));
  EXPECT_TRUE(j.at("match").at("accepted"));
  EXPECT_GT(j.at("match").at("inlier_ratio"), j.at("match").at("inlier_threshold"));
  const size_t a = mapOf(j, "a").at("occupied_voxels"), b = mapOf(j, "b").at("occupied_voxels");
  const size_t both_maps = mapOf(j, "fused").at("occupied_voxels");
  EXPECT_GT(both_maps, std::max(a, b));
  EXPECT_LT(both_maps, a + b);
  EXPECT_EQ(readFile(dir_ / "view.png").substr(1, 3), "PNG");
}

TEST_F(Fusing, NeedsNoGuess) {
  const auto r = mapFusion("fuse " + both() + " -o fused.ot --pose-out T.txt --json report.json");
  ASSERT_EQ(r.code, 0) << r.err;
  expectNearTruth(dir_ / "T.txt");
  const Json j = report();
  EXPECT_FALSE(j.contains("initial_pose"));
  EXPECT_FALSE(j.at("match").at("ambiguous"));
  EXPECT_GE(j.at("match").at("hypotheses").size(), 2U);
}

TEST_F(Fusing, LooksAsFarAsTheGuessIsSaidToBeOff) {
  const std::string arguments = "match " + both() + " --init " + guess(5, 0) + " --pose-out T.txt";
  ASSERT_EQ(mapFusion(arguments + " --init-sigma 2.5 10").code, 0);
  expectNearTruth(dir_ / "T.txt");
  EXPECT_EQ(mapFusion(arguments + " --init-sigma 0.1 1").code, 3);
  EXPECT_EQ(mapFusion(arguments + " --init-sigma -1 1").code, 2);
  EXPECT_EQ(mapFusion(arguments + " --init-sigma 1").code, 2);
  EXPECT_EQ(mapFusion("match " + both() + " --init-sigma 1 1").code, 2) << "of which guess?";
}

TEST_F(Fusing, LeavesLessUncertaintyThanThePapersBaselines) {
  std::map<std::string, double> entropy;
  for (const std::string policy : {"relative_entropy", "average", "stitch", "bayes"}) {
    const auto r = mapFusion("merge " + both() + " --pose " + pair("T_a_b.txt") + " --policy " +
                             policy + " -o fused.ot --json report.json");
    ASSERT_EQ(r.code, 0) << r.err;
    entropy[policy] = mapOf(report(), "fused").at("mean_entropy_occupied_nats");
  }
  EXPECT_LT(entropy["relative_entropy"], entropy["average"]);
  EXPECT_LT(entropy["relative_entropy"], entropy["stitch"]);
  EXPECT_LT(entropy["bayes"], entropy["relative_entropy"]);
}

TEST_F(Fusing, AGuess30mOffIsNoWorseThanNone) {
  const auto r = mapFusion("match " + both() + " --init " + guess(30, 0) + " --pose-out T.txt");
  ASSERT_EQ(r.code, 0) << r.out << r.err;
  expectNearTruth(dir_ / "T.txt");
}

TEST_F(Fusing, AGuess30mOffThatIsSaidToBeGoodIsRejectedAndNothingIsMerged) {
  const std::string arguments = "fuse " + both() + " --init " + guess(30, 0) +
                                " --init-sigma 0.5 5 -o fused.ot --json report.json";
  const auto r = mapFusion(arguments);
  EXPECT_EQ(r.code, 3);
  EXPECT_NE(r.out.find("REJECTED"), std::string::npos);
  EXPECT_FALSE(fs::exists(dir_ / "fused.ot"));
  EXPECT_FALSE(report().at("match").at("accepted"));

  EXPECT_EQ(mapFusion(arguments + " --force").code, 3) << "the verdict stays";
  EXPECT_TRUE(fs::exists(dir_ / "fused.ot")) << "but it is merged";
}

TEST_F(Fusing, AMatchedPoseFeedsEvaluateAndMerge) {
  ASSERT_EQ(mapFusion("match " + both() + " --init " + guess(-0.5, -5) + " --pose-out T.txt").code,
            0);
  expectNearTruth(dir_ / "T.txt");
  EXPECT_EQ(mapFusion("evaluate " + both() + " --pose T.txt --json report.json").code, 0);
  const Json j = report();
  EXPECT_GT(j.at("match").at("edges_a"), 0);
  EXPECT_GT(j.at("match").at("edges_b"), 0);
  for (int i = 0; i < 6; i++) {
    EXPECT_GT(j.at("pose").at("covariance")[i][i], 0) << i;
    EXPECT_LT(j.at("pose").at("covariance")[i][i], 1e-2) << i;
  }
  EXPECT_EQ(mapFusion("merge " + both() + " --pose T.txt -o fused.bt").code, 0);
  octomap::OcTree fused(0.1);
  EXPECT_TRUE(fused.readBinary((dir_ / "fused.bt").string()));
  EXPECT_EQ(mapFusion("evaluate " + both() + " --pose \"[5 5 0 90 0 0]\"").code, 3);
}

TEST_F(Fusing, DoesNotDependOnTheNumberOfThreads) {
  const std::string arguments = "fuse " + both() + " --init " + guess(1, 10) + " -o ";
  ASSERT_EQ(mapFusion(arguments + "one.ot --pose-out one.txt --threads 1").code, 0);
  ASSERT_EQ(mapFusion(arguments + "two.ot --pose-out two.txt --threads 2").code, 0);
  EXPECT_EQ(readFile(dir_ / "one.ot"), readFile(dir_ / "two.ot"));
  EXPECT_EQ(readFile(dir_ / "one.txt"), readFile(dir_ / "two.txt"));
}

TEST_F(Fusing, LeavesTheInputsAlone) {
  const std::string before = readFile(pair("map_a.ot"));
  mapFusion("merge " + both() + " --pose " + pair("T_a_b.txt") + " -o fused.ot");
  EXPECT_EQ(readFile(pair("map_a.ot")), before);
  fs::copy(pair("map_a.ot"), dir_ / "a.ot");
  const auto r =
      mapFusion("merge a.ot " + pair("map_b.ot") + " --pose " + pair("T_a_b.txt") + " -o a.ot");
  EXPECT_EQ(r.code, 1) << "an input is no output";
  EXPECT_EQ(readFile(dir_ / "a.ot"), before);
}

TEST_F(Fusing, TakesTheSettingsOfAnIniFile) {
  writeFile(dir_ / "settings.ini", "[ProbabilisticMapMatching]\nmax_free_conflict = 0\n");
  const std::string arguments = "evaluate " + both() + " --pose " + pair("T_a_b.txt");
  EXPECT_EQ(mapFusion(arguments).code, 0);
  EXPECT_EQ(mapFusion(arguments + " --config settings.ini").code, 3)
      << "no conflict is allowed now";
}

TEST_F(Fusing, DrawsASceneOfNamedObjects) {
  const auto r = mapFusion("fuse " + both() + " --init " + guess(1, 10) +
                           " -o fused.ot --scene view.3Dscene --json report.json");
  ASSERT_EQ(r.code, 0) << r.err;
  mrpt::opengl::COpenGLScene scene;
  ASSERT_TRUE(scene.loadFromFile((dir_ / "view.3Dscene").string()));
  const Json j = report();
  const auto voxelsOf = [&](const char* name) {
    const auto voxels =
        std::dynamic_pointer_cast<mrpt::opengl::COctoMapVoxels>(scene.getByName(name));
    return voxels ? voxels->getVoxelCount(0) : 0;
  };
  EXPECT_EQ(voxelsOf("map A"), mapOf(j, "a").at("occupied_voxels"));
  EXPECT_EQ(voxelsOf("map B"), mapOf(j, "b").at("occupied_voxels"));
  EXPECT_EQ(voxelsOf("fused map"), mapOf(j, "fused").at("occupied_voxels"));
  const auto linesOf = [&](const char* name) {
    const auto lines = std::dynamic_pointer_cast<mrpt::opengl::CSetOfLines>(scene.getByName(name));
    return lines ? lines->getLineCount() : 0;
  };
  EXPECT_EQ(linesOf("inliers"), j.at("match").at("inliers"));
  EXPECT_EQ(linesOf("inliers") + linesOf("outliers"), j.at("match").at("pairs"));
  for (const char* name : {"edges A", "edges B"}) {
    const auto set = std::dynamic_pointer_cast<mrpt::opengl::CSetOfObjects>(scene.getByName(name));
    ASSERT_TRUE(set) << name;
    EXPECT_GT(set->getByClass<mrpt::opengl::CSetOfLines>()->getLineCount(), 1000U);
  }
  const auto truth = readMatrix(pair("T_a_b.txt"));
  for (const char* name : {"map B", "edges B"}) {
    const auto pose = scene.getByName(name)->getPose();
    EXPECT_NEAR(pose.x, truth(0, 3), 0.1) << name;
    EXPECT_NEAR(pose.y, truth(1, 3), 0.1) << name;
  }
}

}  // namespace
