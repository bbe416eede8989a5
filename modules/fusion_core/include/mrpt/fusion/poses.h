// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/poses/CPose3D.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <Eigen/Geometry>

#include "fusion_core/registration/optimization.h"
#include "fusion_core/search/search.h"

/** \file
 * Poses as MRPT has them. */

namespace mrpt::fusion {

/** Of the same pose (m). */
Eigen::Isometry3d toEigen(const mrpt::poses::CPose3D& pose);
/** Of the same pose (m). */
mrpt::poses::CPose3D toPose(const Eigen::Isometry3d& T);

/** From the covariance of a left perturbation of T (translation, rotation; A's frame) to MRPT's of
 * (x, y, z, yaw, pitch, roll). Singular at pitch = +-90 deg, as those angles are. */
Matrix6d toYawPitchRollCovariance(const Matrix6d& covariance, const Eigen::Isometry3d& T);

/** The search that a prior asks for: up to three standard deviations away. With a zero covariance
 * the one configured; from a kilometre on everywhere(). A configured translation of 0, no search,
 * stays. */
SearchParams searchWithin(const mrpt::poses::CPose3DPDFGaussian& prior,
                          const SearchParams& configured);
/** Of how many standard deviations searchWithin() is. */
constexpr double kSearchSigmas = 3;

/** A prior that says nothing but where up is. */
mrpt::poses::CPose3DPDFGaussian noGuess();

}  // namespace mrpt::fusion
