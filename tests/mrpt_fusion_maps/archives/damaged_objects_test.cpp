// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of flags, numbers and poses in streams that no writer writes. */

#include <mrpt/fusion/map_files.h>
#include <mrpt/maps/CColouredOctoMap.h>
#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/maps/COctoMap.h>
#include <mrpt/obs/CObservationLocalMap.h>

#include <functional>
#include <limits>

#include "mrpt_fusion_maps/archives/crafted.h"
using namespace map_tests;
using mrpt::maps::CColouredOctoMap;
using mrpt::maps::CEdgeVoxelMap;
using mrpt::maps::CMetricMap;
using mrpt::maps::COctoMap;
using mrpt::maps::CProbOctoMap;
using mrpt::obs::CObservationLocalMap;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/** Returns the serialized object in which the byte of a flag is 69.
 * \param[in] flag The flag. It changes and changes back. */
std::string withWrongFlag(const mrpt::serialization::CSerializable& object, bool& flag) {
  std::string bytes = serialized(object);
  flag = !flag;
  const std::string other = serialized(object);
  flag = !flag;
  EXPECT_EQ(bytes.size(), other.size());
  size_t at = 0;
  while (at < bytes.size() && bytes[at] == other[at]) at++;
  EXPECT_LT(at, bytes.size()) << "the flag is not serialized";
  if (at < bytes.size()) bytes[at] = 69;
  return bytes;
}

template <class Options>
std::vector<bool*> flagsOf(Options& o) {
  return {&o.generateGridLines, &o.generateOccupiedVoxels, &o.visibleOccupiedVoxels,
          &o.generateFreeVoxels, &o.visibleFreeVoxels};
}

std::vector<bool*> genericFlagsOf(CMetricMap& map) {
  auto& g = map.genericMapParams;
  return {&g.enableSaveAs3DObject, &g.enableObservationLikelihood, &g.enableObservationInsertion};
}

CObservationLocalMap holding(const CMetricMap::Ptr& map) {
  CObservationLocalMap o;
  o.sensorLabel = "a";
  o.map = map;
  return o;
}

void expectRefused(const std::string& bytes, const std::string& reason) {
  const std::string error = errorOf([&] { deserialized(bytes); });
  EXPECT_NE(error.find(reason), std::string::npos) << "'" << error << "'";
}

}  // namespace

// ---------------------------------------------------------------- flags

TEST(DamagedObject, AFlagThatIsNeitherTrueNorFalseIsAnError) {
  CProbOctoMap map(smallTree());
  for (const auto& flags :
       {genericFlagsOf(map), flagsOf(map.renderingOptions), {&map.insertionOptions.pruning}})
    for (bool* flag : flags) expectRefused(withWrongFlag(map, *flag), "a flag");
  CEdgeVoxelMap edges;
  for (bool* flag : genericFlagsOf(edges)) expectRefused(withWrongFlag(edges, *flag), "a flag");
}

TEST(DamagedObject, AFlagOfAnotherMapInALocalMapIsCheckedToo) {
  const auto octomap = std::make_shared<COctoMap>(0.1);
  const auto coloured = std::make_shared<CColouredOctoMap>(0.1);
  for (bool* flag : flagsOf(octomap->renderingOptions))
    expectRefused(withWrongFlag(holding(octomap), *flag), "a flag");
  for (bool* flag : flagsOf(coloured->renderingOptions))
    expectRefused(withWrongFlag(holding(coloured), *flag), "a flag");
  for (const CMetricMap::Ptr& map : {CMetricMap::Ptr(octomap), CMetricMap::Ptr(coloured)})
    for (bool* flag : genericFlagsOf(*map))
      expectRefused(withWrongFlag(holding(map), *flag), "a flag");
}

// ---------------------------------------------------------------- numbers

TEST(DamagedObject, AnOptionThatIsNotANumberIsAnError) {
  const double numbers[] = {7.125, 0.5625, 0.8125, 0.375, 0.0625, 0.9375};
  const float log_odds[] = {-1.25F, 4.75F, 0.9375F, -0.4375F, 0.1875F};
  CProbOctoMap map(smallTree());
  auto& i = map.insertionOptions;
  double* const fields[] = {&i.maxrange, &i.occupancyThres,   &i.probHit,
                            &i.probMiss, &i.clampingThresMin, &i.clampingThresMax};
  for (size_t k = 0; k < std::size(fields); k++) *fields[k] = numbers[k];
  mrpt::fusion::OcTreeAccess::setSensorModel(
      map.octree(), {log_odds[0], log_odds[1], log_odds[2], log_odds[3], log_odds[4]});
  const std::string good = serialized(map);
  ASSERT_NO_THROW(deserialized(good));
  for (const double number : numbers) expectRefused(withNumber(good, number, kNaN), "not a number");
  for (const float number : log_odds)
    expectRefused(withNumber(good, number, std::numeric_limits<float>::quiet_NaN()),
                  "not a number");
}

TEST(DamagedObject, AVoxelSizeOutOfRangeIsAnError) {
  mrpt::fusion::EdgeVoxels voxels;
  voxels.resolution = 0.123;
  voxels.direction_radius = 0.5;
  voxels.centre.emplace_back(0.05F, 0.05F, 0.05F);
  voxels.probability.push_back(0.9F);
  for (const std::string& good :
       {serialized(CProbOctoMap(0.123)), serialized(CEdgeVoxelMap(voxels)),
        serialized(holding(std::make_shared<CProbOctoMap>(0.123)))}) {
    ASSERT_NO_THROW(deserialized(good));
    for (const double size : {1e38, 1.7e308, 1e-5, 0.0, -0.1, kNaN, kInfinity})
      expectRefused(withNumber(good, 0.123, size), "a voxel size of");
  }
}

// ---------------------------------------------------------------- poses

TEST(DamagedObject, APoseOutOfRangeIsAnError) {
  CObservationLocalMap o = holding(nullptr);
  for (const double far : {1e18, -1e9, kNaN, kInfinity}) {
    for (int axis = 0; axis < 3; axis++) {
      o.pose.mean = mrpt::poses::CPose3D();
      o.pose.mean.m_coords[axis] = far;
      expectRefused(serialized(o), "the pose is out of range");
    }
  }
  o.pose.mean = mrpt::poses::CPose3D(5e6, -4e6, 3e6, 1, 0.1, 0.2);
  EXPECT_NO_THROW(deserialized(serialized(o)));
}

TEST(DamagedObject, ACovarianceThatIsNoneIsAnError) {
  CObservationLocalMap o = holding(nullptr);
  for (const double variance : {-1e-9, 1e18, kNaN, kInfinity})
    for (int i = 0; i < 6; i++) {
      o.pose.cov.setDiagonal(6, 1.0);
      o.pose.cov(i, i) = variance;
      expectRefused(serialized(o), "the covariance of the pose is");
    }
  o.pose.cov.setDiagonal(6, 1.0);
  o.pose.cov(0, 1) = o.pose.cov(1, 0) = 1.5;
  expectRefused(serialized(o), "correlation");
  o.pose.cov(0, 1) = o.pose.cov(1, 0) = 1;
  EXPECT_NO_THROW(deserialized(serialized(o)));
}

TEST(DamagedObject, TheReasonIsInTheMessage) {
  const TempDir dir;
  CObservationLocalMap o = holding(nullptr);
  o.pose.mean.x(1e18);
  writeRaw(dir.path("pose"), serialized(o));
  writeRaw(dir.path("voxels"), withNumber(serialized(CProbOctoMap(0.123)), 0.123, 1e38));
  for (const auto& [name, reason] : std::map<std::string, std::string>{
           {"pose", "a coordinate of 1e+18 m"}, {"voxels", "a voxel size of 1e+38 m"}}) {
    const std::string path = dir.path(name);
    const std::string error = errorOf([&] { mrpt::fusion::loadAnyMap(path); });
    EXPECT_NE(error.find(reason), std::string::npos) << error;
    EXPECT_EQ(error.find("Exception"), std::string::npos) << error;
  }
}

// ---------------------------------------------------------------- octrees of MRPT

TEST(DamagedObject, TheOctreeOfAnMrptMapIsReadByOurParser) {
  COctoMap map(0.1);
  for (int i = 0; i < 40; i++) map.updateVoxel(0.1 * i, 1, 0.5, true);
  const std::string good = serialized(holding(std::make_shared<COctoMap>(map)));
  ASSERT_NO_THROW(deserialized(good));
  const size_t data = good.find("\ndata\n") + 6, size = 60;
  ASSERT_LT(data + size, good.size());
  std::string deep = good;
  deep.replace(data, size, size, '\xff');  // each node has 8 children that have children
  expectRefused(deep, "deeper than 16");
  expectRefused(replaced(good, "res 0.1", "res 1e9"), "a voxel size of");
}

TEST(DamagedObject, MrptMapsInALocalMapStayAsTheyAre) {
  const auto octomap = std::make_shared<COctoMap>(0.1);
  const auto coloured = std::make_shared<CColouredOctoMap>(0.1);
  for (int i = 0; i < 40; i++) {
    octomap->updateVoxel(0.1 * i, 1, 0.5, i % 3 != 0);
    coloured->updateVoxel(0.1 * i, 1, 0.5, i % 3 != 0);
  }
  octomap->likelihoodOptions.decimation = 7;
  octomap->renderingOptions.generateGridLines = true;
  const auto copyOf = [](const CMetricMap::Ptr& map) {
    return std::dynamic_pointer_cast<CObservationLocalMap>(deserialized(serialized(holding(map))))
        ->map;
  };
  const auto same = std::dynamic_pointer_cast<COctoMap>(copyOf(octomap));
  ASSERT_TRUE(same);
  EXPECT_EQ(serialized(*same), serialized(*octomap));
  const auto same_coloured = std::dynamic_pointer_cast<CColouredOctoMap>(copyOf(coloured));
  ASSERT_TRUE(same_coloured);
  EXPECT_EQ(serialized(*same_coloured), serialized(*coloured));
}
