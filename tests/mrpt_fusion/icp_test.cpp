// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/poses/CPose3DPDF.h>
#include <mrpt/slam/CICP.h>

#include "support/test_maps.h"

namespace mrpt::fusion::test::icp_test {
namespace {

TEST(MrptsIcp, AlignsPointsWithOurMap) {
  const mrpt::maps::CProbOctoMap map(apartment());
  const mrpt::maps::CSimplePointsMap& obstacles = *map.getAsSimplePointsMap();
  const mrpt::poses::CPose3D pose(0.06, -0.05, 0.04, 0.02, 0.01, -0.01);
  mrpt::maps::CSimplePointsMap scan;  // as the robot sees them
  for (size_t i = 0; i < obstacles.size(); i += 7) {
    mrpt::math::TPoint3D p;
    obstacles.getPoint(i, p.x, p.y, p.z);
    const auto q = pose.inverseComposePoint(p);
    scan.insertPoint(static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z));
  }
  ASSERT_GT(scan.size(), 1000U);
  mrpt::slam::CICP icp;
  icp.options.thresholdDist = 0.3;
  icp.options.thresholdAng = 0;
  mrpt::slam::CICP::TReturnInfo info;
  const auto found = icp.Align3D(&map, &scan, mrpt::poses::CPose3D(), info)->getMeanVal();
  EXPECT_LT(pose.distanceTo(found), 0.01);
  EXPECT_NEAR(pose.yaw(), found.yaw(), 0.005);
  EXPECT_NEAR(pose.pitch(), found.pitch(), 0.005);
  EXPECT_NEAR(pose.roll(), found.roll(), 0.005);
}

}  // namespace
}  // namespace mrpt::fusion::test::icp_test
