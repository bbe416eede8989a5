// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/voxels.h>

#include <Eigen/Geometry>

#include "fusion_core/features/surfaces.h"
#include "fusion_core/registration/normal_equations.h"

/** \file
 * The errors that the two levels minimise, eqs. (21) and (22), and their weights. */

namespace mrpt::fusion {

/** Eq. (21), the edge level: returns the normal equations for e = m - T s and
 * W = (Sigma_m + R Sigma_s R')^-1 with the fused covariances of eq. (9). m is the voxel of A, s is
 * the voxel of B. */
NormalEquations linearizeEdges(const EdgeVoxels& a, const EdgeVoxels& b, const Pairs& pairs,
                               const Eigen::Isometry3d& T_a_b, VoxelCovariance kind);

/** Returns only NormalEquations::error of linearizeEdges(). */
double edgeError(const EdgeVoxels& a, const EdgeVoxels& b, const Pairs& pairs,
                 const Eigen::Isometry3d& T_a_b, VoxelCovariance kind);

/** Eq. (22), the voxel level: returns the normal equations for W = (1/p_m + 1/p_s)^-1 I. */
NormalEquations linearizeVoxels(const OccupiedVoxels& a, const OccupiedVoxels& b,
                                const Pairs& pairs, const Eigen::Isometry3d& T_a_b);
/** Returns only NormalEquations::error of linearizeVoxels(). */
double voxelError(const OccupiedVoxels& a, const OccupiedVoxels& b, const Pairs& pairs,
                  const Eigen::Isometry3d& T_a_b);

/** The voxel level with surfaces (not in the paper, after Segal et al., "Generalized-ICP"): returns
 * the normal equations.
 *
 * A voxel with a normal has a small variance across its surface and a large variance along it. W is
 * the factor of eq. (22) times (C_m + R C_s R')^-1 with C = I - (1 - flatness) n n', so surfaces
 * can slide along each other. Voxels without a normal have C = I. The error e is between the points
 * of the surfaces, not between the centres of the voxels. A voxel of B counts as the number of
 * voxels that it represents, Surfaces::weight. */
NormalEquations linearizeSurfaces(const SurfaceVoxels& a, const SurfaceVoxels& b,
                                  const Pairs& pairs, const Eigen::Isometry3d& T_a_b,
                                  double flatness);
/** Returns only NormalEquations::error of linearizeSurfaces(). */
double surfaceError(const SurfaceVoxels& a, const SurfaceVoxels& b, const Pairs& pairs,
                    const Eigen::Isometry3d& T_a_b, double flatness);

/** Returns the scatter of the gradients of linearizeVoxels() by patches of B. The patches are cubes
 * with a \a side (m). The gradients are about the \a centre of the normal equations (m). */
GradientScatter scatterVoxels(const OccupiedVoxels& a, const OccupiedVoxels& b, const Pairs& pairs,
                              const Eigen::Isometry3d& T_a_b, const Eigen::Vector3d& centre,
                              double side);
/** Returns the scatter of the gradients of linearizeSurfaces(), as scatterVoxels(). */
GradientScatter scatterSurfaces(const SurfaceVoxels& a, const SurfaceVoxels& b, const Pairs& pairs,
                                const Eigen::Isometry3d& T_a_b, double flatness,
                                const Eigen::Vector3d& centre, double side);

/** Returns the equations of linearizeSurfaces() with a 7th unknown, the relative growth of B, and
 * with the scatter by patches. The centre is the mean of the pairs. */
SimilarityEquations linearizeSimilarity(const SurfaceVoxels& a, const SurfaceVoxels& b,
                                        const Pairs& pairs, const Eigen::Isometry3d& T_a_b,
                                        double flatness, double side);

}  // namespace mrpt::fusion
