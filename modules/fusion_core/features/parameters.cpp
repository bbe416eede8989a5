// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Lists keys, ranges and meanings of the parameters of features. */
#include "fusion_core/features/parameters.h"

namespace mrpt::fusion {

Parameters parametersOf(FeatureParams& params) {
  EdgeParams& e = params.edges;
  ScaleParams& s = params.scale;
  return {
      number(
          "length_scale", s.fixed, 0, 1e6,
          "Factor of all lengths (m) in this section; 0: from voxel size and extent of the maps"),
      advanced(number("fine_voxel", s.fine_voxel, 1e-4, 1e6,
                      "length_scale = 0: voxel size below which the scale may be below 1, m")),
      advanced(number("coarse_voxel", s.coarse_voxel, 1e-4, 1e6,
                      "length_scale = 0: voxel size above which the scale is above 1, m")),
      advanced(number("small_scene", s.small_scene, 1e-3, 1e9,
                      "length_scale = 0: extent of a map below which the scale may be below 1, m")),
      length("normal_radius", e.normal_radius, 0, 100, "r_N of the normals' PCA, m"),
      length("cost_radius", e.cost_radius, 0, 100, "r_N of the mean angle cost, eq. (5), m"),
      number("min_normal_radius_voxels", e.min_normal_radius_voxels, 1, 20,
             "Least r_N of the normals' PCA, voxels"),
      number("min_cost_radius_voxels", e.min_cost_radius_voxels, 1, 20,
             "Least r_N of the mean angle cost, voxels"),
      number("max_surface_variation", e.max_surface_variation, 0, 1.0 / 3 + 1e-9,
             "Largest lambda_3 / (lambda_1+lambda_2+lambda_3) of a voxel with a normal; 1/3: any"),
      number("min_surface_variation", e.min_surface_variation, 0, 1.0 / 3,
             "Least lambda_3 / (lambda_1+lambda_2+lambda_3) of an edge candidate"),
      number("kappa", e.kappa, 0, 1, "Least mean angle cost of an edge candidate (Table I: 0.5)"),
      length("trace_distance", e.trace_distance, 0, 100,
             "Length d_T of the walks along the surface, m"),
      angle("trace_step_deg", e.trace_step_angle, 0.1, 180, "Angle delta between walks, deg"),
      angle("trace_window_deg", e.trace_window, 0, 90,
            "Walks leave across the edge, at most this angle to either side, and along it; 90: in "
            "all directions, deg"),
      advanced(angle("trace_beside_deg", e.trace_beside, 0, 180,
                     "Walks to the sides are tried where the angle straight across is at most this "
                     "far outside of alpha_min to alpha_max, deg")),
      angle("alpha_min_deg", e.alpha_min, 0, 180, "Least angle between two walks at an edge, deg"),
      angle("alpha_max_deg", e.alpha_max, 0, 180,
            "Largest angle between two walks at an edge, deg"),
      count("outlier_neighbours", e.outlier_neighbours, 1, 1000,
            "Neighbours of the statistical outlier removal"),
      number("outlier_deviations", e.outlier_deviations, 0, kUnlimited,
             "Edge voxels farther from their neighbours than the mean plus this number of standard "
             "deviations are removed"),
      length("direction_radius", e.direction_radius, 0, 100,
             "Radius of the edge voxels that make an edge's covariance, eq. (6), m"),
      length("voxel_spacing", params.voxel_spacing, 0, 1000,
             "Match one voxel of each cube of the octree that is at least this wide, m; 0: all"),
      length("edge_spacing", params.edge_spacing, 0, 1000,
             "Look for one edge voxel in each cube that is at least this wide, m; 0: everywhere, "
             "which a match without a search needs"),
  };
}

FeatureParams scaledBy(FeatureParams params, double scale) {
  if (scale != 1) multiplyLengths(parametersOf(params), scale);
  return params;
}

}  // namespace mrpt::fusion
