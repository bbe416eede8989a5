// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of joined simplemaps. */

#include <mrpt/fusion/map_files.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationStereoImages.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/poses/CPose3DPDFParticles.h>
#include <mrpt/serialization/CArchive.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "mrpt_fusion_maps/recordings/crafted.h"

using namespace map_tests;
using namespace mrpt::fusion;
using namespace mrpt::obs;
using mrpt::maps::CProbOctoMap;
using mrpt::maps::CSimpleMap;
using mrpt::poses::CPose3D;
using mrpt::poses::CPose3DPDFGaussian;

namespace {

/** Returns a pose with a covariance that couples all directions. */
CPose3DPDFGaussian uncertain(const CPose3D& mean, double sigma) {
  CPose3DPDFGaussian pose(mean);
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 6; j++)
      pose.cov(i, j) = sigma * sigma * (i == j ? 1 + 0.2 * i : 0.3 / (1 + std::abs(i - j)));
  return pose;
}

class JoinedSimplemaps : public testing::Test {
 protected:
  TempDir dir_;

  /** Writes a simplemap with one key frame for each observation. \return The file. */
  std::string write(const std::string& name, const std::vector<CObservation::Ptr>& observations,
                    double sigma = 0.01) {
    CSimpleMap frames;
    for (size_t i = 0; i < observations.size(); i++) {
      CSensoryFrame frame;
      frame.insert(observations[i]);
      frames.insert(uncertain(placeAt(static_cast<double>(i)), sigma), frame);
    }
    std::filesystem::create_directories(std::filesystem::path(dir_.path(name)).parent_path());
    writeRaw(dir_.path(name), serialized(frames));
    return dir_.path(name);
  }
  CSimpleMap read(const std::string& path) const {
    CSimpleMap frames;
    EXPECT_TRUE(frames.loadFromFile(path));
    return frames;
  }
  std::string out() const { return dir_.path("joined.simplemap"); }
};

TEST_F(JoinedSimplemaps, HaveTheKeyFramesOfAllMapsInOneFrame) {
  const std::string a = write("a.simplemap", {cloudAt(0), cloudAt(1)});
  const std::string b = write("b.simplemap", {cloudAt(2), cloudAt(3), cloudAt(4)});
  const CPose3D T_a_b(3, -1, 0.2, 0.8, 0.05, -0.03);
  EXPECT_EQ(joinSimpleMaps({{a, {}}, {b, CPose3DPDFGaussian(T_a_b)}}, out()), 5U);
  CProbOctoMap expected;
  for (const int s : {0, 1}) expected.insertObservation(*cloudAt(s), placeAt(s));
  for (const int s : {2, 3, 4}) expected.insertObservation(*cloudAt(s), T_a_b + placeAt(s - 2));
  const auto built = std::dynamic_pointer_cast<CProbOctoMap>(buildMap(out()).map);
  ASSERT_TRUE(built);
  EXPECT_TRUE(sameTree(expected.octree(), built->octree()));
  EXPECT_EQ(readRaw(out()).substr(0, 2), "\x1f\x8b") << "as MRPT writes simplemaps";
}

TEST_F(JoinedSimplemaps, KeepTheKeyFramesOfAMapThatIsNotMoved) {
  CSimpleMap frames;
  auto particles = std::make_shared<mrpt::poses::CPose3DPDFParticles>(7);
  auto frame = CSensoryFrame::Create();
  frame->insert(cloudAt(0));
  frames.insert(particles, frame);
  writeRaw(dir_.path("a.simplemap"), serialized(frames));
  joinSimpleMaps({{dir_.path("a.simplemap"), {}}}, out());
  EXPECT_EQ(serialized(read(out())), serialized(frames));
}

TEST_F(JoinedSimplemaps, ComposeUncertainties) {
  const std::string b = write("b.simplemap", {cloudAt(0), cloudAt(1)}, 0.02);
  const auto T_a_b = uncertain(CPose3D(3, -1, 0.2, 0.8, 0.05, -0.03), 0.03);
  joinSimpleMaps({{b, T_a_b}}, out());
  const CSimpleMap joined = read(out());
  ASSERT_EQ(joined.size(), 2U);
  // The composition of random poses of both distributions.
  std::mt19937 rng(4);
  std::normal_distribution<double> normal;
  const auto drawn = [&](const CPose3DPDFGaussian& pose) {
    const Eigen::Matrix<double, 6, 6> L = pose.cov.asEigen().llt().matrixL();
    Eigen::Matrix<double, 6, 1> v;
    for (int i = 0; i < 6; i++) v[i] = normal(rng);
    v = L * v;
    const auto& m = pose.mean;
    return CPose3D(m.x() + v[0], m.y() + v[1], m.z() + v[2], m.yaw() + v[3], m.pitch() + v[4],
                   m.roll() + v[5]);
  };
  const auto frame = uncertain(placeAt(1), 0.02);
  const CPose3D mean = T_a_b.mean + frame.mean;
  constexpr int kDraws = 40000;
  Eigen::Matrix<double, 6, 6> expected = Eigen::Matrix<double, 6, 6>::Zero();
  for (int i = 0; i < kDraws; i++) {
    const CPose3D p = drawn(T_a_b) + drawn(frame);
    Eigen::Matrix<double, 6, 1> d;
    d << p.x() - mean.x(), p.y() - mean.y(), p.z() - mean.z(), p.yaw() - mean.yaw(),
        p.pitch() - mean.pitch(), p.roll() - mean.roll();
    expected += d * d.transpose() / kDraws;
  }
  mrpt::poses::CPose3DPDF::ConstPtr pose;
  CSensoryFrame::ConstPtr observations;
  joined.get(1, pose, observations);
  CPose3DPDFGaussian actual;
  actual.copyFrom(*pose);
  EXPECT_LT((actual.mean.asVectorVal() - mean.asVectorVal()).norm(), 1e-9);
  EXPECT_LT((actual.cov.asEigen() - expected).norm(), 0.05 * expected.norm());
}

TEST_F(JoinedSimplemaps, FindTheirExternalFiles) {
  const auto external = [](const std::string& file) {
    auto obs = CObservationPointCloud::Create();
    obs->setAsExternalStorage(file,
                              CObservationPointCloud::ExternalStorageFormat::MRPT_Serialization);
    return obs;
  };
  std::vector<PlacedSimpleMap> maps;
  for (const int robot : {0, 1}) {
    const std::string name = robot == 0 ? "one/run" : "two/run";
    maps.push_back({write(name + ".simplemap", {external("cloud.bin")}), {}});
    std::filesystem::create_directories(dir_.path(name + "_Images"));
    mrpt::io::CFileGZOutputStream file(dir_.path(name + "_Images/cloud.bin"));
    const auto cloud = std::dynamic_pointer_cast<CObservationPointCloud>(cloudAt(robot));
    mrpt::serialization::archiveFrom(file) << *cloud->pointcloud;
  }
  maps[1].pose.mean = CPose3D(1, 2, 0, 0.5, 0, 0);
  std::filesystem::create_directories(dir_.path("out"));
  const std::string joined = dir_.path("out/joined.simplemap");
  joinSimpleMaps(maps, joined);
  CProbOctoMap expected;
  expected.insertObservation(*cloudAt(0), placeAt(0));
  expected.insertObservation(*cloudAt(1), maps[1].pose.mean + placeAt(0));
  const auto built = std::dynamic_pointer_cast<CProbOctoMap>(buildMap(joined).map);
  ASSERT_TRUE(built);
  EXPECT_TRUE(sameTree(expected.octree(), built->octree()));
}

TEST_F(JoinedSimplemaps, NameAllKindsOfExternalFilesByTheirPlace) {
  auto picture = CObservationImage::Create();
  picture->image.setExternalStorage("left.jpg");
  auto stereo = CObservationStereoImages::Create();
  stereo->imageLeft.setExternalStorage("left.jpg");
  stereo->imageRight.setExternalStorage("/elsewhere/right.jpg");
  stereo->hasImageRight = true;
  auto ranges = CObservation3DRangeScan::Create();
  ranges->hasRangeImage = true;
  ranges->rangeImage_setSize(2, 2);
  ranges->rangeImage.fill(1000);
  ranges->rangeImage_convertToExternalStorage("ranges.bin", dir_.path("") + "/");
  ranges->hasIntensityImage = true;
  ranges->intensityImage.setExternalStorage("colours.jpg");
  joinSimpleMaps({{write("a.simplemap", {picture, stereo, ranges}), {}}}, out());
  const CSimpleMap joined = read(out());
  const auto observation = [&](size_t i) {
    mrpt::poses::CPose3DPDF::ConstPtr pose;
    CSensoryFrame::ConstPtr frame;
    joined.get(i, pose, frame);
    return *frame->begin();
  };
  const auto joined_picture = std::dynamic_pointer_cast<CObservationImage>(observation(0));
  EXPECT_EQ(joined_picture->image.getExternalStorageFile(), dir_.path("left.jpg"));
  const auto joined_stereo = std::dynamic_pointer_cast<CObservationStereoImages>(observation(1));
  EXPECT_EQ(joined_stereo->imageLeft.getExternalStorageFile(), dir_.path("left.jpg"));
  EXPECT_EQ(joined_stereo->imageRight.getExternalStorageFile(), "/elsewhere/right.jpg");
  const auto joined_ranges = std::dynamic_pointer_cast<CObservation3DRangeScan>(observation(2));
  EXPECT_EQ(joined_ranges->rangeImage_getExternalStorageFile(""), dir_.path("ranges.bin"));
  EXPECT_EQ(joined_ranges->intensityImage.getExternalStorageFile(), dir_.path("colours.jpg"));
  joined_ranges->load();
  EXPECT_EQ(joined_ranges->rangeImage(1, 1), 1000);
}

TEST_F(JoinedSimplemaps, OfBadInputAreNotWritten) {
  const std::string good = write("good.simplemap", {cloudAt(0)});
  const std::string bytes = readRaw(good);
  writeRaw(dir_.path("cut.simplemap"), bytes.substr(0, bytes.size() / 2));
  writeRaw(dir_.path("map.simplemap"), serialized(mapOfClouds({0})));
  for (const std::string bad : {"cut.simplemap", "map.simplemap", "missing.simplemap"}) {
    const std::string error = errorOf([&] {
      joinSimpleMaps({{good, {}}, {dir_.path(bad), {}}}, out());
    });
    EXPECT_EQ(error.find(dir_.path(bad) + ": "), 0U) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    EXPECT_FALSE(std::filesystem::exists(out())) << bad;
  }
}

}  // namespace
