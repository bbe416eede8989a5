// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of recordings that are read once, and of large recordings that are read again. */
#include "mrpt_fusion_maps/recordings/recording.h"

#include <gtest/gtest.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <filesystem>
#include <stdexcept>

#include "mrpt_fusion_maps/recordings/object_writer.h"
#include "support/mrpt_tools.h"
#include "support/observations.h"

namespace {

using mrpt::fusion::ObjectReader;
using mrpt::fusion::Recording;
using mrpt::obs::CObservationPointCloud;
using mrpt::obs::CObservationRobotPose;
using mrpt::serialization::CSerializable;

class RecordingOf : public testing::TestWithParam<uint64_t> {
 protected:
  /** Writes a rawlog of poses and clouds. Each cloud has as many points as its number. */
  std::string write(size_t clouds) const {
    std::vector<CObservationPointCloud::Ptr> all;
    std::vector<const CSerializable*> objects;
    const auto pose = CObservationRobotPose::Create();
    for (size_t i = 1; i <= clouds; i++) {
      all.push_back(map_tests::cloudOf(map_tests::domePoints(1, i)));
      objects.push_back(pose.get());
      objects.push_back(all.back().get());
    }
    mrpt::fusion::saveObjects(objects, dir_.path("log.rawlog"));
    return dir_.path("log.rawlog");
  }

 private:
  map_tests::TempDir dir_;
};
INSTANTIATE_TEST_SUITE_P(KeptBytes, RecordingOf,
                         testing::Values(0, 3000, Recording::kMostKeptBytes));

TEST_P(RecordingOf, GivesAllObjectsInTheirOrder) {
  const std::string path = write(60);
  ObjectReader reader(path);
  const auto first = reader.next();
  Recording recording(path, reader, first, GetParam());
  EXPECT_FALSE(recording.robotPath().empty());
  EXPECT_EQ(recording.latestMaps().count(), 0U);
  size_t count = 0;
  recording.forEachObject([&](const CSerializable& object) {
    const auto* const cloud = dynamic_cast<const CObservationPointCloud*>(&object);
    EXPECT_EQ(cloud ? cloud->pointcloud->size() : 0, count % 2 * (count / 2 + 1));
    count++;
  });
  EXPECT_EQ(count, 120U);
}

TEST_P(RecordingOf, PassesOnWhatTheUserOfAnObjectThrows) {
  const std::string path = write(20);
  ObjectReader reader(path);
  const auto first = reader.next();
  Recording recording(path, reader, first, GetParam());
  size_t count = 0;
  EXPECT_THROW(recording.forEachObject([&](const CSerializable&) {
    if (++count == 7) throw std::runtime_error("stop");
  }),
               std::runtime_error);
  EXPECT_EQ(count, 7U);
}

TEST_P(RecordingOf, AFileThatIsDamagedLaterIsAnErrorAfterTheObjectsBefore) {
  const std::string path = write(20);
  ObjectReader reader(path);
  const auto first = reader.next();
  Recording recording(path, reader, first, GetParam());
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 40);
  size_t count = 0;
  const auto use = [&] { recording.forEachObject([&](const CSerializable&) { count++; }); };
  if (GetParam() == Recording::kMostKeptBytes) {
    use();
    EXPECT_EQ(count, 40U);
  } else {
    EXPECT_THROW(use(), std::runtime_error);
    EXPECT_EQ(count, 39U);
  }
}

}  // namespace
