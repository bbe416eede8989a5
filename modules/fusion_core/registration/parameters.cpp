// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Lists keys, ranges and meanings of the parameters of registration. */
#include "fusion_core/registration/parameters.h"

namespace mrpt::fusion {
namespace {

const Names<VoxelCovariance> kCovarianceNames = {{VoxelCovariance::Plain, "plain"},
                                                 {VoxelCovariance::Quantisation, "quantisation"}};
const Names<VoxelMetric> kMetricNames = {{VoxelMetric::Point, "point"},
                                         {VoxelMetric::Surface, "surface"}};

}  // namespace

Parameters parametersOf(RegistrationParams& params) {
  CovarianceParams& c = params.covariance;
  return {
      number("k1", params.weights.k1, 0, kUnlimited, "Factor of the occupancy weight, eq. (19)"),
      number("k2", params.weights.k2, 0, kUnlimited, "Factor of the direction weight, eq. (20)"),
      choice("voxel_covariance", params.voxel_covariance, kCovarianceNames,
             "Unit of the voxel covariance, eq. (4): plain (m^2, as published), quantisation"),
      length("edge_gate", params.edge_level.gate, 0, kUnlimited,
             "Gate of edge pairs, m (Table I: 2)"),
      length("edge_final_gate", params.edge_level.final_gate, 0, kUnlimited,
             "Final gate of edge pairs, m; the gate shrinks to it while the iterations settle"),
      count("edge_iterations", params.edge_level.max_iterations, 0, kUnlimited,
            "Most iterations at the edge level; 0: skip the level"),
      length("voxel_gate", params.voxel_level.gate, 0, kUnlimited,
             "Gate of voxel pairs, m (Table I: 0.5)"),
      length("voxel_final_gate", params.voxel_level.final_gate, 0, kUnlimited,
             "Final gate of voxel pairs, m; never below min_voxel_gate"),
      advanced(number("min_voxel_gate", params.min_voxel_gate, 0, 100,
                      "Least gate of voxel pairs, voxels of the coarser map")),
      advanced(number("gate_shrink", params.gate_shrink, 0.01, 1,
                      "Factor of a gate after an iteration that settled")),
      advanced(number("settled_step", params.settled_step, 0, kUnlimited,
                      "Largest step of an iteration that settled, times the gate")),
      choice("voxel_metric", params.voxel_metric, kMetricNames,
             "Voxel level: point (eq. 22, as published), surface (along normals)"),
      number("flatness", params.flatness, 1e-6, 1,
             "Variance across over variance along a piece of surface (voxel_metric = surface)"),
      count("voxel_iterations", params.voxel_level.max_iterations, 0, kUnlimited,
            "Most iterations at the voxel level"),
      count("solver_steps", params.solver.max_steps, 1, kUnlimited,
            "Levenberg-Marquardt steps for one set of pairs"),
      advanced(count("first_pairs", params.first_pairs, 1, kUnlimited,
                     "Voxels whose nearest neighbours give the first mean squared distance")),
      length("min_step_translation", params.min_step_translation, 0, kUnlimited,
             "A level has converged when an iteration moves the pose by less than this, m,"),
      angle("min_step_rotation_deg", params.min_step_rotation, 0, 180,
            "and by less than this, deg"),
      advanced(number("held_gate", c.held_gate, 0, 100,
                      "Gate of the pairs of a pose that is moved by one voxel, voxels")),
      advanced(count("held_pairs", c.sample_pairs, 1, kUnlimited,
                     "Number of pairs that measure how firmly the maps hold a pose")),
      advanced(number("held_min_pull", c.min_pull, 0, 1,
                      "Least share of the expected pull back to the pose that counts as held")),
      advanced(length("covariance_patch", c.patch_size, 1e-3, kUnlimited,
                      "Side of the cubes whose pairs have errors in common, m")),
      advanced(number("covariance_common_share", c.common_share, 0, 1,
                      "Share of the quantisation variance that all pairs have in common")),
  };
}

}  // namespace mrpt::fusion
