// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of collections of objects whose number of objects is not true. */

#include <mrpt/fusion/map_files.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/poses/CPosePDFGaussian.h>
#include <sys/resource.h>

#include "mrpt_fusion_maps/archives/crafted.h"
using namespace map_tests;
using mrpt::obs::CActionCollection;
using mrpt::obs::CObservationOdometry;
using mrpt::obs::CSensoryFrame;
using mrpt::poses::CPose3D;

namespace {

/** Returns an observation with a time stamp that is always the same. */
CObservationOdometry::Ptr odometry() {
  auto odometry = CObservationOdometry::Create();
  odometry->timestamp = mrpt::Clock::fromDouble(1.6e9);
  return odometry;
}

CSensoryFrame frame() {
  CSensoryFrame frame;
  frame.insert(odometry());
  frame.insert(odometry());
  return frame;
}

/** Returns a serialized collection of each class. */
std::vector<std::string> collections() {
  mrpt::maps::CMultiMetricMap set;
  set.maps.push_back(std::make_shared<mrpt::maps::CSimplePointsMap>());
  mrpt::maps::CSimpleMap keyframes;
  keyframes.insert(mrpt::poses::CPose3DPDFGaussian(CPose3D(1, 2, 3, 0, 0, 0)), frame());
  CActionCollection actions;
  mrpt::obs::CActionRobotMovement3D movement;
  movement.poseChange.mean = CPose3D(0.1, 0, 0, 0.1, 0, 0);
  actions.insert(movement);
  return {serialized(set), serialized(keyframes), serialized(frame()), serialized(actions)};
}

/** Returns the size of the header of a serialized object: length of the name, name, version. */
size_t headerSize(const std::string& bytes) {
  return 2 + (static_cast<unsigned char>(bytes[0]) & 0x7fU);
}

/** Returns a serialized collection that claims another number of objects. */
std::string claiming(uint32_t count, std::string bytes) {
  return bytes.replace(headerSize(bytes), sizeof(count), bytesOfValue(count));
}

/** Returns a serialized object with another version and more bytes at its beginning. */
std::string withVersion(char version, std::string bytes, const std::string& beginning) {
  const size_t at = headerSize(bytes);
  bytes[at - 1] = version;
  return bytes.insert(at, beginning);
}

/** Largest memory that this process has used, bytes. */
int64_t mostMemory() {
  rusage usage{};
  EXPECT_EQ(::getrusage(RUSAGE_SELF, &usage), 0);
  return int64_t{usage.ru_maxrss} << 10U;
}

}  // namespace

TEST(Collections, AreReadAsMrptWritesThem) {
  for (const auto& bytes : collections()) EXPECT_EQ(serialized(*deserialized(bytes)), bytes);
}

TEST(Collections, TakeNoMemoryForObjectsThatTheStreamOnlyClaims) {
  constexpr uint32_t kClaimed = 1U << 26U;  // entries have 16 bytes or more
  constexpr int64_t kMostMemory = int64_t{256} << 20U;
  const TempDir dir;
  const int64_t before = mostMemory();
  for (const auto& bytes : collections()) {
    const std::string hostile = claiming(kClaimed, bytes);
    const std::string held = replaced(serialized(frame()), serialized(*odometry()), hostile);
    EXPECT_NE(errorOf([&] { deserialized(hostile); }), "");
    EXPECT_NE(errorOf([&] { deserialized(held); }), "");
    for (const auto& file : {hostile, held}) {
      writeRaw(dir.path("map"), file);
      const std::string error = errorOf([&] { mrpt::fusion::loadAnyMap(dir.path("map")); });
      EXPECT_NE(error.find("truncated"), std::string::npos) << error;
    }
    EXPECT_LT(mostMemory() - before, kMostMemory) << bytes.substr(1, headerSize(bytes) - 2);
  }
}

TEST(Collections, OfOldVersionsAreRead) {
  const std::string frame_bytes = serialized(frame());
  const std::string number = bytesOfValue(uint32_t{7}), time = bytesOfValue(uint64_t{1234567});
  EXPECT_EQ(serialized(*deserialized(withVersion(1, frame_bytes, number))), frame_bytes);
  const auto timed = std::dynamic_pointer_cast<CSensoryFrame>(
      deserialized(withVersion(0, frame_bytes, number + time)));
  ASSERT_TRUE(timed);
  ASSERT_EQ(timed->size(), 2U);
  for (const auto& o : *timed) EXPECT_EQ(o->timestamp.time_since_epoch().count(), 1234567);

  const std::string set = collections()[0];
  EXPECT_EQ(serialized(*deserialized(withVersion(11, set, number))), set);

  const mrpt::poses::CPosePDFGaussian flat(mrpt::poses::CPose2D(1, 2, 0.3));
  const mrpt::poses::CPose3DPDFGaussian pose(flat);
  mrpt::maps::CSimpleMap keyframes;
  keyframes.insert(pose, frame());
  const std::string old = replaced(serialized(keyframes), serialized(pose), serialized(flat));
  EXPECT_EQ(serialized(*deserialized(withVersion(0, old, ""))), serialized(keyframes));
}

TEST(Collections, OfUnknownVersionsAreErrors) {
  for (const auto& bytes : collections())
    EXPECT_NE(errorOf([&] { deserialized(withVersion(99, bytes, "")); }), "");
}

TEST(Collections, AnObjectAmongActionsThatIsNoActionIsAnError) {
  const auto bytes = collections().back();
  const std::string movement =
      bytes.substr(headerSize(bytes) + 4, bytes.size() - 5 - headerSize(bytes));
  const std::string wrong = replaced(bytes, movement, serialized(*odometry()));
  const std::string error = errorOf([&] { deserialized(wrong); });
  EXPECT_NE(error.find("no action"), std::string::npos) << error;
}

TEST(Collections, HaveTheClassesOfMrpt) {
  for (const char* name : {"mrpt::maps::CMultiMetricMap", "mrpt::maps::CSimpleMap",
                           "mrpt::obs::CSensoryFrame", "mrpt::obs::CActionCollection"}) {
    const auto* id = mrpt::rtti::findRegisteredClass(name);
    ASSERT_TRUE(id) << name;
    EXPECT_EQ(id->createObject()->GetRuntimeClass(), id) << name;
  }
}
