// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of objects within objects. */

#include <mrpt/fusion/map_files.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationLocalMap.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CSensoryFrame.h>

#include "mrpt_fusion_maps/archives/crafted.h"
using namespace map_tests;
using mrpt::maps::CMultiMetricMap;
using mrpt::obs::CObservationLocalMap;

namespace {

/** Returns the bytes of a local map that holds a map. */
std::string localMapOf(const std::string& map) {
  const auto points = std::make_shared<mrpt::maps::CSimplePointsMap>();
  CObservationLocalMap o;
  o.sensorLabel = "a";
  o.map = points;
  return replaced(serialized(o), serialized(*points), map);
}

/** Returns the bytes of sets of maps within each other. */
std::string setsOfMaps(size_t count) {
  const auto points = std::make_shared<mrpt::maps::CSimplePointsMap>();
  CMultiMetricMap set;
  set.maps.push_back(points);
  return nested(serialized(set), serialized(*points), count, serialized(*points));
}

std::string loadError(const std::string& bytes) {
  const TempDir dir;
  writeRaw(dir.path("map"), bytes);
  return errorOf([&] { mrpt::fusion::loadAnyMap(dir.path("map")); });
}

void expectContains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text.substr(0, 400);
}

}  // namespace

TEST(Nesting, ALocalMapInALocalMapIsAnError) {
  const std::string inner = serialized(CObservationLocalMap());
  const std::string points = serialized(mrpt::maps::CSimplePointsMap());
  for (const size_t depth : {1, 10'000}) {
    const std::string bytes = nested(localMapOf(points), points, depth, inner);
    expectContains(errorOf([&] { deserialized(bytes); }), "not a map");
    expectContains(loadError(bytes), "not a map");
  }
}

TEST(Nesting, SetsOfMapsMayHoldSetsOfMaps) {
  for (const size_t depth : {1, 3, 8}) {
    const auto local = std::dynamic_pointer_cast<CObservationLocalMap>(
        deserialized(localMapOf(setsOfMaps(depth))));
    ASSERT_TRUE(local);
    EXPECT_EQ(serialized(*local->map), setsOfMaps(depth));
  }
}

TEST(Nesting, ThousandsOfSetsOfMapsAreAnError) {
  const std::string sets = setsOfMaps(30'000);
  expectContains(errorOf([&] { deserialized(localMapOf(sets)); }), "within each other");
  expectContains(loadError(localMapOf(sets)), "within each other");
  expectContains(loadError(sets), "within each other");
}

TEST(Nesting, SetsOfMapsThatMrptReadsAreBoundedToo) {
  expectContains(errorOf([&] { deserialized(setsOfMaps(100'000)); }), "within each other");
  for (size_t depth = 1; depth < 100'000; depth *= 2)  // all that is read can be destroyed
    errorOf([&] { deserialized(setsOfMaps(depth)); });
  EXPECT_EQ(serialized(*deserialized(setsOfMaps(20))), setsOfMaps(20));
  // The class is what it was.
  const auto* id = mrpt::rtti::findRegisteredClass("mrpt::maps::CMultiMetricMap");
  EXPECT_EQ(id, CLASS_ID(CMultiMetricMap));
  EXPECT_EQ(id->createObject()->GetRuntimeClass(), id);
}

TEST(Nesting, ThousandsOfObjectsOfOtherClassesAreAnError) {
  const mrpt::obs::CObservationOdometry odometry;
  mrpt::obs::CSensoryFrame frame;
  frame.insert(mrpt::obs::CObservationOdometry::Create(odometry));
  const std::string inner = serialized(odometry);
  expectContains(loadError(nested(serialized(frame), inner, 30'000, inner)), "within each other");
}

TEST(Nesting, AnObjectInASetOfMapsThatIsNoMapIsAnError) {
  const std::string points = serialized(mrpt::maps::CSimplePointsMap());
  const std::string odometry = serialized(mrpt::obs::CObservationOdometry());
  expectContains(loadError(replaced(setsOfMaps(2), points, odometry)), "no map");
  expectContains(loadError(localMapOf(odometry)), "not a map");
}
