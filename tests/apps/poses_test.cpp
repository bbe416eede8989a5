// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the files with poses that `fuse` writes, and of the guesses that it reads. */

#include <mrpt/graphs/CNetworkOfPoses.h>

#include <sstream>

#include "run.h"

namespace {

using mrpt::graphs::CNetworkOfPoses3DInf;

class PosesOfFuse : public AppTest {
 protected:
  /** Runs `fuse` on both maps, and returns the contents of the file with poses. */
  std::string posesAs(const std::string& file, const std::string& more = "") const {
    const auto r = mapFusion("fuse " + both() + " -o fused.ot --poses-out " + file + " " + more);
    EXPECT_EQ(r.code, 0) << r.err;
    return readFile(dir_ / file);
  }
  CNetworkOfPoses3DInf readByMrpt(const std::string& file) const {
    CNetworkOfPoses3DInf graph;
    graph.loadFromTextFile((dir_ / file).string());
    return graph;
  }
  Result fuseWith(const std::string& priors, const std::string& maps) const {
    writeFile(dir_ / "priors.g2o", priors);
    return mapFusion("fuse " + maps + " -o fused.ot --priors priors.g2o");
  }
  Result fuseWith(const std::string& priors) const { return fuseWith(priors, both()); }

  /** The true pose of B in A, moved by \a dx, m, as "x y z qx qy qz qw". */
  static std::string truth(double dx, bool inverse = false) {
    Eigen::Isometry3d T = readMatrix(pair("T_a_b.txt"));
    T.translation().x() += dx;
    if (inverse) T = T.inverse();
    const Eigen::Quaterniond q(T.linear());
    std::ostringstream text;
    text << T.translation().transpose() << " " << q.coeffs().transpose();
    return text.str();
  }
  /** The information of 0.1 m and 0.01 rad. */
  static std::string information() {
    return " 100 0 0 0 0 0 100 0 0 0 0 100 0 0 0 1e4 0 0 1e4 0 1e4\n";
  }
};

TEST_F(PosesOfFuse, AreReadByMrpt) {
  const auto truth_a_b = readMatrix(pair("T_a_b.txt"));
  for (const std::string file : {"poses.g2o", "poses.graph"}) {
    posesAs(file);
    const auto graph = readByMrpt(file);
    ASSERT_EQ(graph.nodes.size(), 2U) << file;
    EXPECT_EQ(graph.root, 0U);
    const auto& pose = graph.nodes.at(1);
    EXPECT_NEAR(pose.x(), truth_a_b(0, 3), 0.1) << file;
    EXPECT_NEAR(pose.y(), truth_a_b(1, 3), 0.1) << file;
    ASSERT_EQ(graph.edges.count({0, 1}), 1U) << file;
    const auto& edge = graph.edges.find({0, 1})->second;
    EXPECT_NEAR(edge.mean.x(), pose.x(), 1e-9) << file;
    EXPECT_NEAR(edge.mean.yaw(), pose.yaw(), 1e-9) << file;
    EXPECT_GT(edge.cov_inv(0, 0), 100) << file << ": 0.1 m";
    EXPECT_GT(edge.cov_inv(3, 3), 1e4) << file << ": 0.01 rad";
  }
}

TEST_F(PosesOfFuse, AreWrittenAsTumAndYaml) {
  const std::string tum = posesAs("poses.tum"), yaml = posesAs("poses.yaml");
  EXPECT_NE(tum.find("\n0 0 0 0 0 0 0 1\n1 31."), std::string::npos) << tum;
  EXPECT_NE(yaml.find("  - id: 1\n    robot: "), std::string::npos) << yaml;
}

TEST_F(PosesOfFuse, OfARejectedMatchAreThoseOfTheFirstMap) {
  const auto r = mapFusion("fuse " + both() + " --init \"[100 0 0 0 0 0]\" --init-sigma 1 5 " +
                           "-o fused.ot --poses-out poses.g2o");
  EXPECT_EQ(r.code, 3) << r.out;
  const auto graph = readByMrpt("poses.g2o");
  EXPECT_EQ(graph.nodes.size(), 1U);
  EXPECT_EQ(graph.edges.size(), 0U);
}

TEST_F(PosesOfFuse, NeedAKnownExtension) {
  const auto r = mapFusion("fuse " + both() + " -o fused.ot --poses-out poses.txt");
  EXPECT_EQ(r.code, 2);
  EXPECT_NE(r.err.find("poses.txt does not end in .g2o"), std::string::npos) << r.err;
  EXPECT_EQ(mapFusion("fuse " + both() + " -o fused.ot --poses-out no/poses.g2o").code, 1);
  EXPECT_EQ(mapFusion("match " + both() + " --poses-out poses.g2o").code, 2);
}

TEST_F(PosesOfFuse, AreGuessesOfTheNextRun) {
  posesAs("poses.g2o");
  const std::string first = readFile(dir_ / "fused.ot");
  const auto r = mapFusion("fuse " + both() + " -o again.ot --priors poses.g2o");
  EXPECT_EQ(r.code, 0) << r.out << r.err;
  EXPECT_EQ(mapFusion("fuse " + both() + " -o again.ot --priors poses.g2o --init guess.txt").code,
            2);
}

TEST_F(PosesOfFuse, GuessesBoundTheSearch) {
  const std::string edge = "EDGE_SE3:QUAT 0 1 ";
  EXPECT_EQ(fuseWith(edge + truth(0.1) + information()).code, 0);
  EXPECT_EQ(fuseWith(edge + truth(5) + information()).code, 3) << "the information is trusted";
  // An edge may be that of A in B's frame.
  EXPECT_EQ(fuseWith("EDGE_SE3:QUAT 1 0 " + truth(0.1, true) + information()).code, 0);
  EXPECT_EQ(fuseWith("EDGE_SE3:QUAT 1 0 " + truth(5, true) + information()).code, 3);
  // The guess of two poses states no covariance, and the search goes farther.
  const std::string first = "# poses\nVERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nFIX 0\nVERTEX_SE3:QUAT 1 ";
  EXPECT_EQ(fuseWith(first + truth(1) + "\n").code, 0);
  EXPECT_EQ(fuseWith(first + truth(15) + "\n").code, 0);
  EXPECT_EQ(fuseWith(first + truth(0) + "\n" + edge + truth(5) + information()).code, 3)
      << "the edge of a pair counts before its poses";
}

TEST_F(PosesOfFuse, GuessesOfAMissionAreByTheIndexOfTheRobot) {
  ASSERT_EQ(mapFusion("pack " + both() + " -o mission.rawlog").code, 0);
  const std::string edge = "EDGE_SE3:QUAT 0 1 ";
  EXPECT_EQ(fuseWith(edge + truth(0.1) + information(), "mission.rawlog").code, 0);
  EXPECT_EQ(fuseWith(edge + truth(5) + information(), "mission.rawlog").code, 3);
  EXPECT_EQ(fuseWith("EDGE_SE3:QUAT 0 2 " + truth(5) + information(), "mission.rawlog").code, 1);
}

TEST_F(PosesOfFuse, BadGuessesAreOneLine) {
  const std::string pose = " 1 0 0 0 0 0 1";
  const std::pair<const char*, std::string> cases[] = {
      {"line 1: '2' is not the index of a map, 0 to 1", "EDGE_SE3:QUAT 0 2" + pose + information()},
      {"line 1: '-1' is not the index of a map", "VERTEX_SE3:QUAT -1" + pose},
      {"line 1: an edge joins map 1 with itself", "EDGE_SE3:QUAT 1 1" + pose + information()},
      {"line 2: 'nan' is not a finite number", "\nVERTEX_SE3:QUAT 0 nan 0 0 0 0 0 1"},
      {"line 1: 'inf' is not a finite number", "VERTEX_SE3:QUAT 0 0 inf 0 0 0 0 1"},
      {"line 1: the quaternion does not have the length 1", "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 0"},
      {"line 1: the information matrix is not positive definite",
       "EDGE_SE3:QUAT 0 1" + pose + " -1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1"},
      {"line 1: the information matrix is not positive definite",
       "EDGE_SE3:QUAT 0 1" + pose + " 0 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1"},
      {"line 1: EDGE_SE3:QUAT needs 28 numbers after the ids", "EDGE_SE3:QUAT 0 1" + pose},
      {"line 1: VERTEX_SE3:QUAT needs 7 numbers after the id", "VERTEX_SE3:QUAT 0 1 2 3"},
      {"line 2: another edge joins maps 1 and 0",
       "EDGE_SE3:QUAT 0 1" + pose + information() + "EDGE_SE3:QUAT 1 0" + pose + information()},
      {"line 2: there is another vertex 0",
       "VERTEX_SE3:QUAT 0" + pose + "\nVERTEX_SE3:QUAT 0" + pose},
      {"line 1: the initial guess is out of range", "VERTEX_SE3:QUAT 0 1e9 0 0 0 0 0 1"},
      {"line 1: 'VERTEX_SE2' is neither VERTEX_SE3:QUAT nor EDGE_SE3:QUAT", "VERTEX_SE2 0 1 2 3"},
      {"line 1: there are characters that belong to no g2o file", "VERTEX_SE3:QUAT \x1b[31m"},
      {"has no VERTEX_SE3:QUAT and no EDGE_SE3:QUAT", "# nothing\n"}};
  for (const auto& [message, text] : cases) {
    const auto r = fuseWith(text);
    EXPECT_EQ(r.code, 1) << text;
    EXPECT_NE(r.err.find(std::string("priors.g2o: ") + message), std::string::npos)
        << r.err << "instead of " << message;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
    EXPECT_FALSE(fs::exists(dir_ / "fused.ot"));
  }
}

}  // namespace
