// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of recordings whose ranges and pictures are in other files. */

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/fusion/map_files.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationStereoImages.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>

#include "mrpt_fusion_maps/recordings/crafted.h"

using namespace map_tests;
using namespace mrpt::fusion;
using namespace mrpt::obs;
using mrpt::maps::CProbOctoMap;

namespace {

CObservation::Ptr missingPicture(double seconds) {
  auto obs = CObservationImage::Create();
  obs->sensorLabel = "CAM";
  obs->image.setExternalStorage("not_there.jpg");
  return stamped(obs, seconds);
}

CObservation::Ptr missingStereoPictures(double seconds) {
  auto obs = CObservationStereoImages::Create();
  obs->imageLeft.setExternalStorage("left.jpg");
  obs->imageRight.setExternalStorage("right.jpg");
  obs->hasImageRight = true;
  return stamped(obs, seconds);
}

/** Returns points whose camera picture is not there. */
CObservation::Ptr pointsWithMissingPicture(double seconds) {
  auto obs = scan3dOf(domePoints(5, 100));
  obs->hasIntensityImage = true;
  obs->intensityImage.setExternalStorage("colours.jpg");
  return stamped(obs, seconds);
}

CObservation::Ptr externalCloud(const std::string& file, double seconds) {
  auto obs = CObservationPointCloud::Create();
  obs->sensorLabel = "LIDAR";
  obs->setAsExternalStorage(file,
                            CObservationPointCloud::ExternalStorageFormat::MRPT_Serialization);
  return stamped(obs, seconds);
}

CObservation::Ptr externalRanges(double seconds) {
  auto obs = CObservation3DRangeScan::Create();
  obs->sensorLabel = "RGBD";
  obs->hasRangeImage = true;
  obs->rangeImage_setSize(2, 2);
  obs->rangeImage.fill(1000);
  const TempDir elsewhere;
  obs->rangeImage_convertToExternalStorage("ranges.bin", elsewhere.path("") + "/");
  return stamped(obs, seconds);
}

std::string simplemapOf(const std::vector<CObservation::Ptr>& observations) {
  mrpt::maps::CSimpleMap frames;
  for (size_t i = 0; i < observations.size(); i++) {
    mrpt::poses::CPose3DPDFGaussian pose;
    pose.mean = placeAt(static_cast<double>(i));
    CSensoryFrame frame;
    frame.insert(observations[i]);
    frames.insert(pose, frame);
  }
  return serialized(frames);
}

size_t countOf(const BuiltMap& built, const std::string& kind, const std::string& reason) {
  size_t count = 0;
  for (const auto& l : built.left_out)
    if (l.kind == kind && l.reason.find(reason) != std::string::npos) count += l.count;
  return count;
}

class ExternalFiles : public testing::Test {
 protected:
  TempDir dir_;

  std::string file(const std::string& name, const std::string& bytes) {
    writeRaw(dir_.path(name), bytes);
    return dir_.path(name);
  }
  void writeCloud(const std::string& name, double seconds) {
    std::filesystem::create_directories(std::filesystem::path(dir_.path(name)).parent_path());
    mrpt::io::CFileGZOutputStream out(dir_.path(name));
    const auto cloud = std::dynamic_pointer_cast<CObservationPointCloud>(cloudAt(seconds));
    mrpt::serialization::archiveFrom(out) << *cloud->pointcloud;
  }
};

}  // namespace

TEST_F(ExternalFiles, MissingPicturesAreLeftOutAndCounted) {
  Objects objects = {robotPoseAt(0),           cloudAt(0), missingPicture(0), robotPoseAt(1),
                     missingStereoPictures(1), cloudAt(1), missingPicture(1)};
  const auto built = buildMap(file("a.rawlog", bytesOf(objects)));
  EXPECT_TRUE(isSameMap(mapOfClouds({0, 1}), built));
  EXPECT_EQ(2U, countOf(built, "CObservationImage", "no map takes"));
  EXPECT_EQ(1U, countOf(built, "CObservationStereoImages", "no map takes"));
  EXPECT_EQ(3U, built.ignored);
}

TEST_F(ExternalFiles, MissingPicturesOfASimplemapAreLeftOut) {
  const auto built = buildMap(file("a.simplemap", simplemapOf({cloudAt(0), missingPicture(1)})));
  EXPECT_TRUE(isSameMap(mapOfClouds({0}), built));
  EXPECT_EQ(1U, countOf(built, "CObservationImage", "no map takes"));
}

TEST_F(ExternalFiles, PointsDoNotNeedTheirPictures) {
  const auto built =
      buildMap(file("a.rawlog", bytesOf({robotPoseAt(0), pointsWithMissingPicture(0)})));
  EXPECT_EQ(1U, built.inserted);
}

TEST_F(ExternalFiles, OtherMapsDoNotNeedPicturesEither) {
  const mrpt::config::CConfigFileMemory ini(
      std::string("[M]\npointsMap_count = 1\noctoMap_count = 1\n"));
  BuildParams params;
  params.config = &ini;
  params.section = "M";
  const auto built =
      buildMap(file("a.rawlog", bytesOf({robotPoseAt(0), missingPicture(0), cloudAt(0)})), params);
  EXPECT_EQ(1U, built.inserted);
  EXPECT_EQ(1U, built.ignored);
}

TEST_F(ExternalFiles, AMissingFileOfRangesIsNamedWithTheReason) {
  const auto errorWith = [&](const CObservation::Ptr& obs) {
    const std::string path = file("a.rawlog", bytesOf({robotPoseAt(0), obs}));
    return errorOf([&] { buildMap(path); });
  };
  const std::string cloud = errorWith(externalCloud("scans/7.bin", 0));
  EXPECT_EQ(0U, cloud.find(dir_.path("a.rawlog") + ": ")) << cloud;
  const std::string ranges = errorWith(externalRanges(0));
  for (const auto& [error, name] :
       {std::pair(cloud, "scans/7.bin"), std::pair(ranges, "ranges.bin")}) {
    EXPECT_NE(std::string::npos, error.find(name)) << error;
    EXPECT_NE(std::string::npos, error.find(dir_.path(name))) << error;
    EXPECT_NE(std::string::npos, error.find("No such file")) << error;
    EXPECT_EQ(std::string::npos, error.find('\n')) << error;
  }
}

TEST_F(ExternalFiles, ADamagedFileIsNamed) {
  std::filesystem::create_directories(dir_.path("Images"));
  file("Images/cloud.bin", "no cloud at all");
  const std::string path =
      file("a.rawlog", bytesOf({robotPoseAt(0), externalCloud("cloud.bin", 0)}));
  const std::string error = errorOf([&] { buildMap(path); });
  EXPECT_NE(std::string::npos, error.find("cloud.bin: ")) << error;
  EXPECT_EQ(std::string::npos, error.find('\n')) << error;
}

TEST_F(ExternalFiles, OfASimplemapAreBesideIt) {
  for (const std::string folder : {"own_Images", "Images"}) {
    const TempDir other_folder;
    writeCloud(folder + "/cloud.bin", 0);
    const std::string bytes = simplemapOf({externalCloud("cloud.bin", 0)});
    for (const std::string name : {"own.simplemap", "own.simplemap.gz"})
      EXPECT_TRUE(isSameMap(mapOfClouds({0}), buildMap(file(name, bytes))))
          << folder << " " << name;
    std::filesystem::remove_all(dir_.path(folder));
  }
}

TEST(LeftOutObservations, HaveReasons) {
  const TempDir dir;
  Objects objects = {robotPoseAt(0), cloudAt(0), cloudAt(9), robotPoseAt(1)};
  auto empty = CObservationPointCloud::Create();
  objects.push_back(stamped(empty, 1));
  objects.push_back(missingPicture(1));
  writeRaw(dir.path("a.rawlog"), bytesOf(objects));
  const auto built = buildMap(dir.path("a.rawlog"));
  EXPECT_EQ(1U, countOf(built, "CObservationPointCloud", "no robot pose at its time"));
  EXPECT_EQ(1U, countOf(built, "CObservationPointCloud", "no points"));
  EXPECT_EQ(1U, countOf(built, "CObservationImage", "no map takes"));
  EXPECT_EQ(3U, built.ignored);
}

TEST(LeftOutObservations, AreNamedIfNoneIsLeft) {
  const TempDir dir;
  writeRaw(dir.path("a.rawlog"), bytesOf({robotPoseAt(0), missingPicture(0), missingPicture(0)}));
  const std::string error = errorOf([&] { buildMap(dir.path("a.rawlog")); });
  EXPECT_NE(std::string::npos, error.find("2 CObservationImage: no map takes")) << error;
}
