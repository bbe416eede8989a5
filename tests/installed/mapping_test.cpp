// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/voxels.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/serialization/CArchive.h>

#include <set>
#include <tuple>

#include "fusion_octree/files.h"
#include "mrpt_programs.h"
#include "support/icp_slam.h"
#include "support/keyframes.h"

using namespace mrpt::maps;

namespace {

using Keys = std::set<std::tuple<unsigned, unsigned, unsigned>>;

/** The finest occupied voxels, pruned ones expanded. */
Keys occupiedKeys(const octomap::OcTree& tree) {
  Keys keys;
  for (const auto& k : mrpt::fusion::extractOccupiedVoxels(tree).key)
    keys.emplace(k[0], k[1], k[2]);
  return keys;
}

std::set<float> logOddsOf(const octomap::OcTree& tree) {
  std::set<float> values;
  for (auto it = tree.begin_leafs(); it != tree.end_leafs(); ++it) values.insert(it->getLogOdds());
  return values;
}

/** Every value and the structure, bit for bit. */
std::string bitsOf(const CProbOctoMap& map) { return mrpt::fusion::serializeNodes(map.octree()); }

CProbOctoMap loaded(const fs::path& path) {
  CProbOctoMap map;
  map.loadFromOcTreeFile(path.string());
  return map;
}

/** Every sixth scan of a recording, as keyframes. COctoMap ignores where the sensor is when it
 * inserts points, so they are given in the robot's frame. */
CSimpleMap keyframesOf(const std::string& rawlog) {
  constexpr size_t kEverySixth = 6;
  CSimpleMap frames = map_tests::keyframesOf(rawlog, kEverySixth);
  for (const auto& frame : frames)
    for (const auto& obs : *frame.sf) {
      auto& scan = dynamic_cast<mrpt::obs::CObservationPointCloud&>(*obs);
      scan.pointcloud->changeCoordinatesReference(scan.sensorPose);
      scan.sensorPose = {};
    }
  return frames;
}

class Mapping : public MrptPrograms {};

TEST_F(Mapping, Observations2mapWritesTheVoxelsOfMrptsMapWithTheirProbabilities) {
  const CSimpleMap frames = keyframesOf(pair("robot_a.rawlog"));
  ASSERT_GT(frames.size(), 5U);
  ASSERT_TRUE(frames.saveToFile((dir_ / "run.simplemap").string()));
  const auto iniOf = [](const std::string& kind) {
    return "[MappingApplication]\n" + kind + "_count = 1\n[MappingApplication_" + kind +
           "_00_creationOpts]\nresolution = 0.2\n[MappingApplication_" + kind +
           "_00_insertOpts]\nmaxrange = 10\n";
  };
  writeFile(dir_ / "ours.ini", iniOf("probOctoMap"));
  writeFile(dir_ / "mrpts.ini", iniOf("octoMap"));
  const auto ours = runWithPlugin("observations2map ours.ini run.simplemap ours");
  ASSERT_EQ(ours.code, 0) << ours.out << ours.err;
  const auto mrpts = run("observations2map mrpts.ini run.simplemap mrpts");
  ASSERT_EQ(mrpts.code, 0) << mrpts.out << mrpts.err;

  const CProbOctoMap of_ours = loaded(dir_ / "ours_mrpt__maps__CProbOctoMap_00.ot");
  const CProbOctoMap of_mrpts = loaded(dir_ / "mrpts_mrpt__maps__COctoMap_00_binary.bt");
  EXPECT_GT(occupiedKeys(of_ours.octree()).size(), 5000U);
  EXPECT_EQ(occupiedKeys(of_ours.octree()), occupiedKeys(of_mrpts.octree()));
  EXPECT_GT(logOddsOf(of_ours.octree()).size(), 20U);
  EXPECT_EQ(logOddsOf(of_mrpts.octree()).size(), 2U) << "MRPT's files hold occupied and free only";

  // What was saved is what was built, bit for bit.
  CProbOctoMap built(0.2);
  built.insertionOptions.maxrange = 10;
  built.loadFromSimpleMap(frames);
  EXPECT_EQ(bitsOf(of_ours), bitsOf(built));
}

/** An object written to a stream and read back. */
template <class Object>
void throughAStream(Object& object) {
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << object;
  stream.Seek(0);
  archive >> object;
}

TEST_F(Mapping, Observations2mapBuildsTheMapOfBothRobotsFromJoinedKeyframes) {
  for (const std::string robot : {"a", "b"})
    ASSERT_TRUE(map_tests::keyframesOf(pair("robot_" + robot + ".rawlog"), 1)
                    .saveToFile((dir_ / (robot + ".simplemap")).string()));
  const auto fused =
      run(mapFusion() + " fuse a.simplemap b.simplemap -o joined.simplemap --pose-out T_a_b.txt");
  ASSERT_EQ(fused.code, 0) << fused.out << fused.err;
  writeFile(dir_ / "map.ini", "[MappingApplication]\nprobOctoMap_count = 1\n");
  const auto r = runWithPlugin("observations2map map.ini joined.simplemap joined");
  ASSERT_EQ(r.code, 0) << r.out << r.err;

  // Both recordings, inserted one after the other at the pose that was found.
  CProbOctoMap expected(0.1);
  const mrpt::poses::CPose3D T_a_b(
      mrpt::math::CMatrixDouble44(readMatrix(dir_ / "T_a_b.txt").matrix()));
  for (const std::string robot : {"a", "b"}) {
    const CSimpleMap frames = map_tests::keyframesOf(pair("robot_" + robot + ".rawlog"), 1);
    for (const auto& frame : frames)
      for (const auto& obs : *frame.sf)
        expected.insertObservation(
            *obs, robot == "b" ? T_a_b + frame.pose->getMeanVal() : frame.pose->getMeanVal());
  }
  const Keys both = occupiedKeys(expected.octree());
  const Keys joined = occupiedKeys(loaded(dir_ / "joined_mrpt__maps__CProbOctoMap_00.ot").octree());
  size_t same = 0;
  for (const auto& key : joined) same += both.count(key);
  // The file of the pose is rounded: a few points change their voxels.
  const double f1 =
      2.0 * static_cast<double>(same) / static_cast<double>(both.size() + joined.size());
  EXPECT_GE(f1, 0.999) << both.size() << " and " << joined.size() << " voxels";
}

TEST_F(Mapping, OnlyOurMapComesBackFromAStreamAsItWent) {
  CProbOctoMap ours(0.2);
  COctoMap mrpts(0.2);
  const CSimpleMap frames = keyframesOf(pair("robot_a.rawlog"));
  ours.loadFromSimpleMap(frames);
  mrpts.loadFromSimpleMap(frames);
  const std::string before = bitsOf(ours);
  EXPECT_EQ(bitsOf(CProbOctoMap(mrpts)), before);
  throughAStream(ours);
  throughAStream(mrpts);
  EXPECT_EQ(bitsOf(ours), before);
  EXPECT_EQ(logOddsOf(CProbOctoMap(mrpts).octree()).size(), 2U);
}

TEST_F(Mapping, IcpSlamBuildsOurMapBesideTheOneItMatchesWith) {
  writeFile(dir_ / "slam.ini", kIcpSlamSettings);
  const auto r = runWithPlugin("icp-slam slam.ini " + kRoundOfABuilding);
  ASSERT_EQ(r.code, 0) << r.out << r.err;
  const CProbOctoMap map = loaded(dir_ / "log/_finalmaps_.txt_mrpt__maps__CProbOctoMap_01.ot");
  EXPECT_GT(occupiedKeys(map.octree()).size(), 1000U);

  // It holds the scans of the keyframes that icp-slam has written beside it.
  CSimpleMap frames;
  ASSERT_TRUE(frames.loadFromFile((dir_ / "log/_finalmap_.simplemap").string()));
  CProbOctoMap of_frames(0.2);
  of_frames.loadFromSimpleMap(frames);
  EXPECT_EQ(bitsOf(map), bitsOf(of_frames));
}

}  // namespace
