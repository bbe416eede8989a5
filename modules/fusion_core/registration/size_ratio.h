// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/registration_params.h>

#include <Eigen/Geometry>

#include "fusion_core/features/surfaces.h"
#include "fusion_core/registration/association.h"

/** \file
 * Measures the size of map B over the size of map A. */

namespace mrpt::fusion {

/** Returns the size of map B over the size of map A at a pose.
 *
 * It solves the equations of the pose with a 7th unknown, the growth of B. Pairs of nearest voxels
 * hide a part of the growth. So B is enlarged by the first result and paired again, until the ratio
 * converges; but only if the first result differs by more than 1 % from 1. Without pairs that
 * determine the size, without convergence and beyond 20 %, the ratio is 1 and its standard
 * deviation infinite. Cost: O(1000 pairs) for maps of the same size.
 *
 * \param[in] a,b Matched voxels of the maps A and B.
 * \param[in] pairs Pairs at the pose.
 * \param[in] T_a_b Pose of map B in A's frame.
 * \param[in] association Association of A's matched voxels.
 * \param[in] H_m See occupancyUncertainty().
 * \param[in] params Settings of registration. */
SizeRatio sizeRatioAt(const SurfaceVoxels& a, const SurfaceVoxels& b, const Pairs& pairs,
                      const Eigen::Isometry3d& T_a_b, const VoxelAssociation& association,
                      double H_m, const RegistrationParams& params);

}  // namespace mrpt::fusion
