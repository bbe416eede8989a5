// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of recordings without time stamps. */

#include <mrpt/fusion/map_files.h>
#include <mrpt/obs/CObservationOdometry.h>

#include "mrpt_fusion_maps/recordings/crafted.h"

using namespace map_tests;
using namespace mrpt::fusion;
using mrpt::maps::CProbOctoMap;

namespace {

class TimeStamps : public testing::Test {
 protected:
  TempDir dir_;
  std::vector<std::string> notes_;

  BuiltMap build(const Objects& objects) {
    writeRaw(dir_.path("a.rawlog"), bytesOf(objects));
    notes_.clear();
    BuildParams params;
    params.note = [this](const std::string& note) { notes_.push_back(note); };
    return buildMap(dir_.path("a.rawlog"), params);
  }
};

Objects withTimes() {
  return {robotPoseAt(0), cloudAt(0), robotPoseAt(1), cloudAt(1), robotPoseAt(2), cloudAt(2)};
}

template <class Change>
Objects changed(Objects objects, Change&& change) {
  for (const auto& o : objects) change(std::dynamic_pointer_cast<mrpt::obs::CObservation>(o));
  return objects;
}

}  // namespace

TEST_F(TimeStamps, WithoutThemTheOrderOfTheLogPlacesObservations) {
  const CProbOctoMap expected = mapOfClouds({0, 1, 2});
  EXPECT_TRUE(isSameMap(expected, build(withTimes())));
  EXPECT_TRUE(notes_.empty());
  const auto built = build(changed(withTimes(), unstamped));
  EXPECT_TRUE(isSameMap(expected, built));
  EXPECT_EQ(3U, built.inserted);
  ASSERT_EQ(1U, notes_.size());
  EXPECT_NE(std::string::npos, notes_.front().find("no time stamps")) << notes_.front();
}

TEST_F(TimeStamps, ThatAreAllTheSameAreNone) {
  EXPECT_TRUE(isSameMap(mapOfClouds({0, 1, 2}),
                        build(changed(withTimes(), [](const auto& obs) { stamped(obs, 7); }))));
  EXPECT_EQ(1U, notes_.size());
}

TEST_F(TimeStamps, ThatOneObservationLacksAreReplacedByTheOrderOfTheLog) {
  Objects objects = withTimes();
  unstamped(std::dynamic_pointer_cast<mrpt::obs::CObservation>(objects[3]));
  EXPECT_TRUE(isSameMap(mapOfClouds({0, 1, 2}), build(objects)));
  EXPECT_TRUE(notes_.empty());
}

TEST_F(TimeStamps, APoseThatLacksThemIsCountedAmongPosesThatHaveThem) {
  Objects objects = withTimes();
  unstamped(std::dynamic_pointer_cast<mrpt::obs::CObservation>(objects[2]));
  const auto built = build(objects);
  EXPECT_EQ(3U, built.inserted) << "the second pose is interpolated";
  ASSERT_EQ(1U, built.left_out.size());
  EXPECT_EQ("CObservationRobotPose", built.left_out.front().kind);
  EXPECT_EQ(1U, built.left_out.front().count);
  EXPECT_NE(std::string::npos, built.left_out.front().reason.find("time stamp"));
}

TEST_F(TimeStamps, WithoutThemObservationsBeforeTheFirstPoseAreLeftOut) {
  Objects objects = changed(withTimes(), unstamped);
  objects.insert(objects.begin(), unstamped(cloudAt(5)));
  const auto built = build(objects);
  EXPECT_TRUE(isSameMap(mapOfClouds({0, 1, 2}), built));
  EXPECT_EQ(1U, built.ignored);
  ASSERT_EQ(1U, built.left_out.size());
  EXPECT_NE(std::string::npos, built.left_out.front().reason.find("before it in the log"));
}

TEST_F(TimeStamps, OdometryWithoutThemHasAnOrder) {
  Objects objects;
  CProbOctoMap expected;
  for (const double s : {0.0, 1.0, 2.0}) {
    const auto odometry = mrpt::obs::CObservationOdometry::Create();
    odometry->odometry = {0.5 * s, 0.1 * s, 0.2 * s};
    objects.push_back(unstamped(odometry));
    objects.push_back(unstamped(cloudAt(s)));
    expected.insertObservation(*cloudAt(s), mrpt::poses::CPose3D(odometry->odometry));
  }
  EXPECT_TRUE(isSameMap(expected, build(objects)));
}
