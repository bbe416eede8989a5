// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/voxels.h>

#include <Eigen/Geometry>

#include "fusion_core/features/surfaces.h"
#include "fusion_core/registration/normal_equations.h"

/** \file
 * What the two levels minimise, eqs. (21) and (22): errors of pairs and their weights. */

namespace mrpt::fusion {

/** Eq. (21), the edge level: e = m - T s, W = (Sigma_m + R Sigma_s R')^-1 with the fused
 * covariances of eq. (9). */
NormalEquations linearizeEdges(const EdgeVoxels& a, const EdgeVoxels& b, const Pairs& pairs,
                               const Eigen::Isometry3d& T_a_b, VoxelCovariance kind);

/** NormalEquations::error of linearizeEdges() alone. */
double edgeError(const EdgeVoxels& a, const EdgeVoxels& b, const Pairs& pairs,
                 const Eigen::Isometry3d& T_a_b, VoxelCovariance kind);

/** Eq. (22), the voxel level: W = (1/p_m + 1/p_s)^-1 I. */
NormalEquations linearizeVoxels(const OccupiedVoxels& a, const OccupiedVoxels& b,
                                const Pairs& pairs, const Eigen::Isometry3d& T_a_b);
/** NormalEquations::error of linearizeVoxels() alone. */
double voxelError(const OccupiedVoxels& a, const OccupiedVoxels& b, const Pairs& pairs,
                  const Eigen::Isometry3d& T_a_b);

/** The voxel level with directions (not in the paper, after Segal et al., "Generalized-ICP"): a
 * voxel with a normal is a piece of surface, well known across it and hardly along it. W is eq.
 * (22)'s factor times (C_m + R C_s R')^-1, C = I - (1 - flatness) n n', so that surfaces slide
 * along each other; voxels without a normal have C = I. e is between the surfaces' points, not the
 * voxels' centres. A voxel of B that stands for several (Surfaces::weight) counts as so many.
 * The surfaces hold one piece per voxel. */
NormalEquations linearizeSurfaces(const SurfaceVoxels& a, const SurfaceVoxels& b,
                                  const Pairs& pairs, const Eigen::Isometry3d& T_a_b,
                                  double flatness);
/** NormalEquations::error of linearizeSurfaces() alone. */
double surfaceError(const SurfaceVoxels& a, const SurfaceVoxels& b, const Pairs& pairs,
                    const Eigen::Isometry3d& T_a_b, double flatness);

/** The gradients of linearizeVoxels(), by patches of B: cubes of a \a side (m), about the
 * \a centre of the normal equations (m). */
GradientScatter scatterVoxels(const OccupiedVoxels& a, const OccupiedVoxels& b, const Pairs& pairs,
                              const Eigen::Isometry3d& T_a_b, const Eigen::Vector3d& centre,
                              double side);
/** The same of linearizeSurfaces(). */
GradientScatter scatterSurfaces(const SurfaceVoxels& a, const SurfaceVoxels& b, const Pairs& pairs,
                                const Eigen::Isometry3d& T_a_b, double flatness,
                                const Eigen::Vector3d& centre, double side);

}  // namespace mrpt::fusion
