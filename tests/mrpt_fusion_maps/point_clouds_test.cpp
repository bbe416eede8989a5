// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of point clouds as maps of MRPT. */

#include <mrpt/fusion/map_files.h>

#include <string>
#include <vector>

#include "fusion_octree/point_clouds/cloud_map.h"
#include "support/cloud_files.h"
#include "support/tree_tools.h"

using namespace map_tests;
using namespace mrpt::fusion;

TEST(PointCloudFiles, AreLoadedAsMapsWithTheParameters) {
  const TempDir dir;
  const Points points = {{1, 2, 0.5F}, {1.02F, 2, 0.5F}, {-2, 0.3F, 1}};
  BuildParams with_sensor;
  with_sensor.cloud_resolution = 0.05;
  with_sensor.cloud_sensor_origin = mrpt::math::TPoint3D(0.1, -0.2, 0.3);
  for (const auto& file : cloudFiles(points)) {
    writeRaw(dir.path(file.name), file.bytes);
    EXPECT_TRUE(sameTree(*parseCloudMap(file.bytes, {}), loadMap(dir.path(file.name))->octree()))
        << file.name;
    const CloudParams params{0.05, octomap::point3d(0.1F, -0.2F, 0.3F)};
    EXPECT_TRUE(sameTree(*parseCloudMap(file.bytes, params),
                         loadMap(dir.path(file.name), with_sensor)->octree()))
        << file.name;
  }
}

TEST(PointCloudFiles, GiveNotes) {
  const TempDir dir;
  writeRaw(dir.path("cloud.ply"), plyFile({{1, 2, 3}}, "ascii"));
  std::vector<std::string> notes;
  BuildParams params;
  params.note = [&](const std::string& note) { notes.push_back(note); };
  loadMap(dir.path("cloud.ply"), params);
  ASSERT_EQ(notes.size(), 2U);
  EXPECT_NE(notes[0].find("mesh"), std::string::npos);
  EXPECT_NE(notes[1].find("no free space"), std::string::npos);
}

TEST(PointCloudFiles, ThatAreDamagedAreNamed) {
  const TempDir dir;
  writeRaw(dir.path("cut.pcd"), pcdFile({{1, 2, 3}}, "binary").substr(0, 200));
  const std::string error = errorOf([&] { loadMap(dir.path("cut.pcd")); });
  EXPECT_EQ(error.find(dir.path("cut.pcd") + ": point cloud (.pcd): "), 0U) << error;
}
