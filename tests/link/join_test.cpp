// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of map-fusion join: robots that meet over a thin link. */
#include <unistd.h>

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "apps/run.h"
#include "support/icp_slam.h"

namespace {

using std::chrono::seconds;

/** Robots r1, r2, ... with small maps, each in a network namespace. */
class Join : public AppTest {
 protected:
  void SetUp() override {
    AppTest::SetUp();
#ifndef HAS_LINK
    GTEST_SKIP() << "this build has no CycloneDDS";
#endif
    // Three maps of 20 kB each: less than a second of the link.
    map("r1", pair("map_a.ot"), "[0 0 0 0 0 0]");
    map("r2", pair("map_b.ot"), "[0 0 0 0 0 0]");
    ASSERT_EQ(mapFusion("build -q " + pair("all.rawlog") + " -o all.ot").code, 0);
    map("r3", "all.ot", "[3 -2 0.1 50 0 0]");
  }
  void TearDown() override {
    if (has_network_) network("down");
    run("for p in *.pid; do kill -9 $(cat $p); done");
    AppTest::TearDown();
  }

  /** Makes a map with voxels of 0.25 m, in another frame. */
  void map(const std::string& name, const std::string& from, const std::string& pose) {
    const auto made = mapFusion("transform -q " + from + " --resolution 0.25 --pose '" + pose +
                                "' -o " + name + ".ot");
    ASSERT_EQ(made.code, 0) << made.err;
  }
  /** Calls network.sh. */
  Result network(const std::string& what, const std::string& arguments = "") {
    return run(std::string(NETWORK) + " " + what + " " + prefix() + " " + arguments);
  }
  /** Makes the namespaces. \return False if that is not possible here. */
  bool connect(int robots) {
    has_network_ = true;
    const auto up = network("up", std::to_string(robots));
    reason_ = "no network namespaces with tc and nft here: " + up.err;
    return up.code == 0;
  }
  static std::string prefix() { return "mf" + std::to_string(::getpid()) + "r"; }

  /** Starts robot \a i in its namespace. */
  void start(int i, const std::string& more = "", const std::string& environment = "") {
    const std::string n = std::to_string(i), r = "r" + n;
    runAs(i, environment + " " MAP_FUSION " join --robot " + r + " --map " + r +
                 ".ot --domain 7 -o fused" + n + ".ot --journal journal" + n + " " + more);
  }
  /** Runs a program as robot \a i. */
  void runAs(int i, const std::string& program) {
    const std::string n = std::to_string(i);
    run(NETWORK " run " + prefix() + " " + n + " env " + program + " >>log" + n +
        " 2>&1 & echo $! >r" + n + ".pid");
  }
  void signal(int i, const char* name) {
    run(std::string("kill -") + name + " $(cat r" + std::to_string(i) + ".pid)");
  }
  bool allEnded() const {
    return run("for p in r?.pid; do ! kill -0 $(cat $p) || exit 1; done").code == 0;
  }
  /** Waits until something holds. \return False if it takes too long. */
  static bool waitFor(const std::function<bool()>& holds, seconds most) {
    const auto end = std::chrono::steady_clock::now() + most;
    while (!holds()) {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
    return true;
  }
  /** Fuses the maps as `map-fusion fuse` does it, to expected.ot. */
  void expectFusionOf(const std::string& maps) {
    const auto fused = mapFusion("fuse -q " + maps + " -o expected.ot");
    ASSERT_EQ(fused.code, 0) << fused.err;
  }
  bool hasExpected(int i) const {
    const fs::path fused = dir_ / ("fused" + std::to_string(i) + ".ot");
    return fs::exists(fused) && readFile(fused) == readFile(dir_ / "expected.ot");
  }
  std::string logs() const {
    std::string text;
    for (int i = 1; i <= 3; i++)
      text += "log" + std::to_string(i) + ":\n" + readFile(dir_ / ("log" + std::to_string(i)));
    return text;
  }

  bool has_network_ = false;
  std::string reason_;
};

class JoinWithLoss : public Join, public testing::WithParamInterface<int> {};

TEST_P(JoinWithLoss, ThreeRobotsOfWhichOneComesLateGetTheFusedMapOfFuse) {
  ASSERT_NO_FATAL_FAILURE(expectFusionOf("r1.ot r2.ot r3.ot"));
  if (!connect(3)) GTEST_SKIP() << reason_;
  ASSERT_EQ(network("loss", "2 " + std::to_string(GetParam())).code, 0);
  start(1);
  start(2);
  std::this_thread::sleep_for(seconds(5));
  start(3);
  for (int i = 1; i <= 3; i++)
    ASSERT_TRUE(waitFor([&] { return hasExpected(i); }, seconds(60))) << i << "\n" << logs();
  for (int i = 1; i <= 3; i++) signal(i, "TERM");
  EXPECT_TRUE(waitFor([&] { return allEnded(); }, seconds(10)));
}

INSTANTIATE_TEST_SUITE_P(Percent, JoinWithLoss, testing::Values(0, 20, 60));

TEST_F(Join, AfterAPartitionAndAKillAllRobotsHaveTheSameMapAgain) {
  if (!connect(3)) GTEST_SKIP() << reason_;
  ASSERT_NO_FATAL_FAILURE(expectFusionOf("r1.ot r2.ot"));
  start(1);
  start(2);
  ASSERT_TRUE(waitFor([&] { return hasExpected(1) && hasExpected(2); }, seconds(40))) << logs();
  ASSERT_EQ(network("cut", "1").code, 0);
  signal(2, "KILL");
  map("r1", pair("map_a.ot"), "[0 0 0 5 0 0]");  // r1 changes its map while nobody hears it
  start(3);
  std::this_thread::sleep_for(seconds(8));
  start(2);
  std::this_thread::sleep_for(seconds(8));
  ASSERT_NO_FATAL_FAILURE(expectFusionOf("r1.ot r2.ot r3.ot"));
  ASSERT_EQ(network("heal", "1").code, 0);
  for (int i = 1; i <= 3; i++)
    ASSERT_TRUE(waitFor([&] { return hasExpected(i); }, seconds(30))) << i << "\n" << logs();
}

TEST_F(Join, ARobotAloneContinuesWithWhatItsJournalHolds) {
  if (!connect(2)) GTEST_SKIP() << reason_;
  ASSERT_NO_FATAL_FAILURE(expectFusionOf("r1.ot r2.ot"));
  start(1);
  start(2);
  ASSERT_TRUE(waitFor([&] { return hasExpected(1) && hasExpected(2); }, seconds(40))) << logs();
  signal(1, "KILL");
  signal(2, "KILL");
  fs::remove(dir_ / "fused2.ot");
  start(2);
  EXPECT_TRUE(waitFor([&] { return hasExpected(2); }, seconds(15))) << logs();
}

TEST_F(Join, EndsWhenAllMapsAreThereAndSaysWhatIsGoingOn) {
  ASSERT_NO_FATAL_FAILURE(expectFusionOf("r1.ot r2.ot"));
  if (!connect(2)) GTEST_SKIP() << reason_;
  start(1, "--peer 10.77.0.2 --until-complete 2 --poses-out p.g2o --report page.html");
  start(2, "--peer 10.77.0.1 --until-complete 2");
  EXPECT_TRUE(waitFor([&] { return allEnded(); }, seconds(50))) << logs();
  EXPECT_TRUE(hasExpected(1) && hasExpected(2)) << logs();
  EXPECT_TRUE(fs::exists(dir_ / "p.g2o") && fs::exists(dir_ / "page.html"));
  EXPECT_NE(readFile(dir_ / "log1").find("r1 complete | r2 complete | fused r1, r2\n"),
            std::string::npos)
      << logs();
}

TEST_F(Join, ARobotThatLeavesBeforeAllMapsAreThereSaysSo) {
  if (!connect(1)) GTEST_SKIP() << reason_;
  const auto left =
      network("run", "1 " MAP_FUSION
                     " join --robot r1 --map r1.ot --domain 7 -o f.ot --until-complete 2 --for 2");
  EXPECT_EQ(left.code, 3) << left.err;
  EXPECT_NE(left.err.find("left before the team was complete: 1 of 2 maps"), std::string::npos)
      << left.err;
  EXPECT_NE(left.err.find("f.ot was not written: fewer than 2 maps have joined"), std::string::npos)
      << left.err;
  EXPECT_FALSE(fs::exists(dir_ / "f.ot"));
}

TEST_F(Join, MapsThatDoNotJoinAreReportedAndNotMerged) {
  if (!connect(2)) GTEST_SKIP() << reason_;
  ASSERT_EQ(
      mapFusion("build -q /usr/share/mrpt/datasets/localization_demo.simplemap.gz -o r2.ot").code,
      0);
  start(2);
  const auto joined = network("run", "1 " MAP_FUSION
                                     " join --robot r1 --map r1.ot --domain 7 -o fused1.ot"
                                     " --until-complete 2 --for 40 --report page.html"
                                     " --poses-out poses.tum --json report.json");
  EXPECT_EQ(joined.code, 3) << joined.err << logs();
  EXPECT_EQ(joined.out.find("merged by"), std::string::npos) << joined.out;
  EXPECT_FALSE(fs::exists(dir_ / "fused1.ot"));
  EXPECT_TRUE(fs::exists(dir_ / "page.html") && fs::exists(dir_ / "poses.tum"));
  ASSERT_EQ(report().at("robots").size(), 2U);
  for (const auto& robot : report().at("robots")) EXPECT_FALSE(robot.at("joined")) << robot;
}

TEST_F(Join, ABaseStationWithoutAMapFollowsMapsThatChange) {
  if (!connect(3)) GTEST_SKIP() << reason_;
  fs::remove(dir_ / "r3.ot");
  ASSERT_NO_FATAL_FAILURE(expectFusionOf("r1.ot r2.ot"));
  start(1);
  start(2);
  runAs(3, MAP_FUSION " join --robot base --domain 7 -o fused3.ot");
  ASSERT_TRUE(waitFor([&] { return hasExpected(3); }, seconds(40))) << logs();
  map("r2", pair("map_b.ot"), "[1 0 0 0 0 0]");
  ASSERT_NO_FATAL_FAILURE(expectFusionOf("r1.ot r2.ot"));
  for (int i = 1; i <= 3; i++)
    ASSERT_TRUE(waitFor([&] { return hasExpected(i); }, seconds(40))) << i << "\n" << logs();
}

TEST_F(Join, ARecordedMissionIsFusedAsTheRobotsHaveFusedIt) {
  if (!connect(2)) GTEST_SKIP() << reason_;
  ASSERT_NO_FATAL_FAILURE(expectFusionOf("r1.ot r2.ot"));
  start(1, "--record mission.rawlog");
  start(2);
  ASSERT_TRUE(waitFor([&] { return hasExpected(1); }, seconds(40))) << logs();
  const auto size = fs::file_size(dir_ / "mission.rawlog");
  map("r2", pair("map_b.ot"), "[1 0 0 0 0 0]");
  ASSERT_NO_FATAL_FAILURE(expectFusionOf("r1.ot r2.ot"));
  ASSERT_TRUE(waitFor([&] { return hasExpected(1); }, seconds(40))) << logs();
  signal(1, "KILL");
  EXPECT_GT(fs::file_size(dir_ / "mission.rawlog"), size);
  EXPECT_EQ(mapFusion("info mission.rawlog").code, 0);
  const auto fused = mapFusion("fuse -q mission.rawlog -o recorded.ot");
  ASSERT_EQ(fused.code, 0) << fused.err;
  EXPECT_TRUE(readFile(dir_ / "recorded.ot") == readFile(dir_ / "expected.ot"));
  // The robot was killed. Its next run continues the recording.
  start(1, "--record mission.rawlog --until-complete 2");
  ASSERT_TRUE(waitFor([&] { return run("! kill -0 $(cat r1.pid)").code == 0; }, seconds(40)))
      << logs();
  ASSERT_EQ(mapFusion("fuse -q mission.rawlog -o recorded.ot").code, 0);
  EXPECT_TRUE(readFile(dir_ / "recorded.ot") == readFile(dir_ / "expected.ot"));
}

TEST_F(Join, TheRecordingOfOneRobotIsItsMap) {
  const auto joined =
      mapFusion("join -q --robot r1 --map r1.ot --domain 12 --for 2 --record r1.rawlog");
  ASSERT_EQ(joined.code, 0) << joined.err;
  ASSERT_EQ(mapFusion("build -q r1.rawlog -o built.ot").code, 0);
  EXPECT_TRUE(readFile(dir_ / "built.ot") == readFile(dir_ / "r1.ot"));
  EXPECT_EQ(mapFusion("match -q r1.rawlog r2.ot").code, 0);
}

TEST_F(Join, AMapFileThatIsDeletedIsNotedOnceAndTheRobotStays) {
  run(MAP_FUSION
      " join --robot r1 --map r1.ot --domain 11 -o fused1.ot >log1 2>&1 & echo $! >r1.pid");
  const auto log = [&] { return readFile(dir_ / "log1"); };
  ASSERT_TRUE(waitFor([&] { return log().find("r1 complete") != std::string::npos; }, seconds(20)));
  fs::remove(dir_ / "r1.ot");
  const std::string note = "r1.ot: is gone (the last map that was read stays)";
  EXPECT_TRUE(waitFor([&] { return log().find(note) != std::string::npos; }, seconds(10))) << log();
  std::this_thread::sleep_for(seconds(3));
  EXPECT_FALSE(allEnded()) << log();
  EXPECT_EQ(log().find(note, log().find(note) + 1), std::string::npos) << log();
}

TEST_F(Join, AProgramJoinsThroughTheClassOfTheTeam) {
  ASSERT_NO_FATAL_FAILURE(expectFusionOf("r1.ot r2.ot r3.ot"));
  if (!connect(3)) GTEST_SKIP() << reason_;
  start(1);
  start(2);
  runAs(3, TEAM_MEMBER " r3 7 r3.ot fused3.ot");
  for (int i = 1; i <= 3; i++)
    ASSERT_TRUE(waitFor([&] { return hasExpected(i); }, seconds(60))) << i << "\n" << logs();
}

TEST_F(Join, AProgramOfMrptSendsItsMapWhenItsSettingsAskForIt) {
  if (!connect(2)) GTEST_SKIP() << reason_;
  writeFile(dir_ / "slam.ini", kIcpSlamSettings + R"([MappingApplication_probOctoMap_00_linkOpts]
robot = slam
domain = 7
)");
  runAs(2, MAP_FUSION " join --robot base --domain 7 --record slam.rawlog");
  const auto slam =
      run("ip netns exec " + prefix() + "1 env LD_PRELOAD=" FUSION_LIBRARY " icp-slam slam.ini " +
          kRoundOfABuilding);
  ASSERT_EQ(slam.code, 0) << slam.out << slam.err;
  const std::string map = readFile(dir_ / "log/_finalmaps_.txt_mrpt__maps__CProbOctoMap_01.ot");
  const auto has_all = [&] {
    return mapFusion("build -q slam.rawlog -o sent.ot").code == 0 &&
           readFile(dir_ / "sent.ot") == map;
  };
  EXPECT_TRUE(waitFor(has_all, seconds(10))) << logs() << slam.err;
}

TEST_F(Join, RobotsWithCertificatesMeetAndOthersStayOutside) {
  ASSERT_NO_FATAL_FAILURE(expectFusionOf("r1.ot r2.ot"));
  if (!connect(3)) GTEST_SKIP() << reason_;
  const auto made = run(SECURITY " keys r1 r2");
  if (made.code != 0) GTEST_SKIP() << "no plugins of DDS Security, or no openssl: " << made.err;
  const auto secured = [&](int i) {
    const std::string n = std::to_string(i);
    start(i, "", "CYCLONEDDS_URI=file://" + (dir_ / "keys/r").string() + n + ".xml");
  };
  start(3);  // without a certificate
  secured(1);
  secured(2);
  for (int i = 1; i <= 2; i++)
    ASSERT_TRUE(waitFor([&] { return hasExpected(i); }, seconds(60))) << i << "\n" << logs();
  for (int i = 1; i <= 2; i++)
    EXPECT_EQ(readFile(dir_ / ("log" + std::to_string(i))).find("r3"), std::string::npos) << logs();
  EXPECT_EQ(readFile(dir_ / "log3").find("r1"), std::string::npos) << logs();
  EXPECT_EQ(readFile(dir_ / "log3").find("r2"), std::string::npos) << logs();
}

TEST_F(Join, ARobotWithTheNameOfAnotherLeaves) {
  if (!connect(2)) GTEST_SKIP() << reason_;
  start(1, "--quiet");
  std::this_thread::sleep_for(seconds(12));
  const auto twin = run("ip netns exec " + prefix() +
                        "2 timeout 60 " MAP_FUSION " join -q --robot r1 --map r2.ot --domain 7");
  EXPECT_EQ(twin.code, 1);
  EXPECT_EQ(twin.err,
            "map-fusion: another robot of this domain has the name r1: each robot needs a name of "
            "its own\n");
  EXPECT_EQ(run("kill -0 $(cat r1.pid)").code, 0);
  const std::string note = "another robot of this domain has the name r1";
  EXPECT_TRUE(
      waitFor([&] { return readFile(dir_ / "log1").find(note) != std::string::npos; }, seconds(5)))
      << logs();
}

TEST_F(Join, BadInputIsOneLine) {
  writeFile(dir_ / "bad.ot", "no map");
  writeFile(dir_ / "bad.rawlog", "no mission");
  const std::string name(64, 'n');
  for (const std::string arguments :
       {"--robot r1 --map none.ot", "--robot r1 --map bad.ot", "--robot '' --for 1",
        "--robot r1 --peer 'a b' --for 1", "--robot r1 --journal r1.ot --for 1",
        "--robot r1 --record bad.rawlog --for 1"}) {
    const auto bad = mapFusion("join --domain 9 " + arguments);
    EXPECT_EQ(bad.code, 1) << arguments << bad.out;
    EXPECT_EQ(std::count(bad.err.begin(), bad.err.end(), '\n'), 1) << arguments << "\n" << bad.err;
  }
  EXPECT_EQ(mapFusion("join --robot " + name + " --for 1").code, 1);
  EXPECT_EQ(mapFusion("join --map r1.ot").code, 2);
  EXPECT_EQ(mapFusion("join --robot r1 --domain 500").code, 2);
  EXPECT_EQ(mapFusion("join --robot r1 --record mission.gz --for 1").code, 2);
}

}  // namespace
