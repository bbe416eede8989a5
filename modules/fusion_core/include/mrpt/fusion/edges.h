// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <mrpt/fusion/voxels.h>

#include <Eigen/Core>
#include <string>
#include <vector>

/** \file
 * The paper's Algorithm 1: structural edge voxels, and edge voxels as octrees and as PLY text. */

namespace mrpt::fusion {

/** Settings of Algorithm 1. The paper gives kappa, d_T and the angle window; the other values are
 * ours. Lengths are limited to 64 voxels, normal_radius to 20 voxels: the cost per voxel grows with
 * the cube of the radius. */
struct EdgeParams {
  double normal_radius = 0.25;  ///< r_N for the normals' PCA, lines 2-6, m
  double cost_radius = 0.60;    ///< r_N for the angle cost, eq. (5), m
  /** Least normal_radius, in voxels, so that voxels of coarse maps have neighbours too. */
  double min_normal_radius_voxels = 2.5;
  double min_cost_radius_voxels = 6.0;  ///< Least cost_radius, in voxels
  /** Largest surface variation lambda_3 / (lambda_1 + lambda_2 + lambda_3) of a voxel with a
   * normal. The variation is near 0 on a plane, 0.09 on a clean right-angled edge and 1/3 inside a
   * solid. */
  double max_surface_variation = 0.2;
  /** Least surface variation of a candidate (not in the paper). A flatter surface has no edge, so
   * its angle cost is not computed. */
  double min_surface_variation = 0.045;
  double kappa = 0.5;                            ///< Least mean angle cost of a candidate (Table I)
  double trace_distance = 0.5;                   ///< Length d_T of a walk, m
  double trace_step_angle = 0.2617993877991494;  ///< Angle delta between walks, rad (15 deg)
  /** Largest angle between a walk and the direction straight across the edge, rad (30 deg). The
   * normals around a voxel suggest that direction. One more pair of walks follows the edge. The
   * paper walks in all directions: 90 deg. */
  double trace_window = 0.5235987755982988;
  /** Largest distance from the angle window (alpha_min, alpha_max) of the angle straight across the
   * edge for which walks in the other directions are tried, rad (20 deg). If the surface is far
   * from a bend straight across, a bend in another direction is chance. */
  double trace_beside = 0.3490658503988659;
  double alpha_min = 1.3962634015954636;  ///< Least angle of the two walks of an edge, rad (80 deg)
  double alpha_max = 1.7453292519943295;  ///< Largest angle of these walks, rad (100 deg)
  unsigned outlier_neighbours = 8;        ///< Number of neighbours in the outlier test (line 23)
  double outlier_deviations = 1.0;  ///< Largest distance above the mean, in standard deviations
  double direction_radius = 0.5;    ///< Radius of the edge voxels of Sigma_tau, eq. (6), m
};

/** Unit of p^-1 of eq. (4). Eq. (7) combines it with the m^2 of eq. (6). */
enum class VoxelCovariance {
  Plain,        ///< p^-1 m^2 for any voxel size, as published
  Quantisation  ///< p^-1 times the variance of a uniform position in a voxel, d_m^2 / 12
};

/** Eq. (6): eigen-decomposition of the covariance of the edge voxels around an edge voxel. */
struct MRPT_FUSION_API EdgeCovariance {
  Eigen::Vector3d eigenvalues = Eigen::Vector3d::Zero();       ///< Eigenvalues, ascending, m^2
  Eigen::Matrix3d eigenvectors = Eigen::Matrix3d::Identity();  ///< Eigenvectors, as columns

  /** Edge direction tau, a unit vector of arbitrary sign. */
  Eigen::Vector3d direction() const { return eigenvectors.col(2); }
  /** Term of eq. (16) of this edge: 1 on a perfect line, 1/3 without a main direction. */
  double linearity() const;
  /** Covariance plus \a floor_variance (m^2) along each axis. The neighbours on a perfect line have
   * no extent across the line, but their voxels have. */
  Eigen::Matrix3d matrix(double floor_variance) const;
};

/** The edge voxels of a map, as parallel arrays. */
struct EdgeVoxels {
  double resolution = 0;                   ///< Voxel size, m
  double direction_radius = 0;             ///< Radius of the edge voxels of Sigma_tau, m
  std::vector<Eigen::Vector3f> centre;     ///< Centres, m, map frame
  std::vector<float> probability;          ///< Probabilities of being occupied, (0,1]
  std::vector<EdgeCovariance> covariance;  ///< Sigma_tau of each edge voxel, eq. (6)

  size_t size() const { return centre.size(); }  ///< Number of edge voxels
};

/** Runs all of Algorithm 1, and eq. (6) for the edge voxels found. The result does not depend on
 * the number of threads. Cost: O(voxels * neighbours).
 * \param[in] voxels All occupied voxels of a map.
 * \param[in] params Settings; all fields are used. */
MRPT_FUSION_API EdgeVoxels extractEdges(const OccupiedVoxels& voxels, const EdgeParams& params);

/** Makes an octree with the edge voxels occupied and all other space unknown. Without edge voxels,
 * the octree is empty and has a resolution of 0.1 m.
 * \exception std::exception As probabilityTree(). */
MRPT_FUSION_API octomap::OcTree occupancyTree(const EdgeVoxels& edges);

/** Makes an octree with one finest leaf for each edge voxel. The value of the leaf is the
 * probability itself: a conversion to log-odds would lose its last bits.
 * \exception std::exception If the resolution is not positive, an edge voxel lies outside an
 * octree's grid (32767 voxels from the origin), or a probability is not in (0,1]. */
MRPT_FUSION_API octomap::OcTree probabilityTree(const EdgeVoxels& edges);

/** Inverts probabilityTree(). The edge voxels are in the order of the octree. Eq. (6) is computed
 * again.
 * \param[in] tree An octree of probabilityTree().
 * \param[in] direction_radius See EdgeParams, m.
 * \exception std::exception If the octree does not hold edge voxels. */
MRPT_FUSION_API EdgeVoxels edgesOf(const octomap::OcTree& tree, double direction_radius);

/** Writes edge voxels as the text of a PLY point cloud. The properties are x y z, the direction of
 * the edge as nx ny nz, probability and linearity(). */
MRPT_FUSION_API std::string toPly(const EdgeVoxels& edges);

}  // namespace mrpt::fusion
