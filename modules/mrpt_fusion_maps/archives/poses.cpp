// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Checks poses that come from outside. */

#include "mrpt_fusion_maps/archives/poses.h"

#include <mrpt/core/exceptions.h>
#include <mrpt/core/format.h>

#include <Eigen/Core>
#include <cmath>

namespace mrpt::fusion {

void checkPose(const mrpt::poses::CPose3DPDFGaussian& pose) {
  const auto& mean = pose.mean;
  for (int i = 0; i < 3; i++)
    ASSERTMSG_(std::abs(mean.m_coords[i]) <= kMostPoseCoordinate,  // false for nan
               mrpt::format("the pose is out of range: a coordinate of %g m", mean.m_coords[i]));
  ASSERTMSG_(mean.getRotationMatrix().asEigen().allFinite(),
             "the pose is out of range: a rotation that is not finite");

  constexpr double kMostVariance = kMostPoseCoordinate * kMostPoseCoordinate;
  constexpr double kRounding = 1e-6;  // variances of poses that were composed are not exact
  for (int i = 0; i < 6; i++)
    ASSERTMSG_(pose.cov(i, i) >= 0 && pose.cov(i, i) <= kMostVariance,
               mrpt::format("the covariance of the pose is out of range: a variance of %g",
                            pose.cov(i, i)));
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < i; j++) {
      const double most = std::sqrt(pose.cov(i, i) * pose.cov(j, j));
      ASSERTMSG_(std::abs(pose.cov(i, j) - pose.cov(j, i)) <= kRounding * (1 + most) &&
                     std::abs(pose.cov(i, j)) <= most + kRounding * (1 + most),
                 "the covariance of the pose is wrong: a correlation above 1");
    }
}

}  // namespace mrpt::fusion
