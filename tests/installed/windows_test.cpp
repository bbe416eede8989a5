// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/maps/CProbOctoMap.h>

#include "mrpt_programs.h"

namespace {

class Windows : public MrptPrograms {};

TEST_F(Windows, SceneViewer3DShowsAMap) {
  mrpt::maps::CProbOctoMap map;
  map.loadFromOcTreeFile(pair("map_a.ot"));
  map.renderingOptions.generateFreeVoxels = false;
  map.saveMetricMapRepresentationToFile((dir_ / "map").string());
  expectShows("SceneViewer3D", "map_3D.3Dscene", 5000);
}

TEST_F(Windows, SceneViewer3DShowsAFusion) {
  const auto r = run(mapFusion() + " fuse " + pair("map_a.ot") + " " + pair("map_b.ot") +
                     " -o fused.ot --scene fusion.3Dscene");
  ASSERT_EQ(r.code, 0) << r.err;
  expectShows("SceneViewer3D", "fusion.3Dscene", 5000);
}

TEST_F(Windows, RawLogViewerShowsAMission) {
  const auto r =
      run(mapFusion() + " pack " + pair("map_a.ot") + " " + pair("map_b.ot") + " -o m.rawlog");
  ASSERT_EQ(r.code, 0) << r.err;
  expectShows("RawLogViewer", "--load=" + plugin() + " m.rawlog", 1000);
}

TEST_F(Windows, RawLogViewerShowsARecording) {
  expectShows("RawLogViewer", "--load=" + plugin() + " " + pair("robot_a.rawlog"), 1000);
}

}  // namespace
