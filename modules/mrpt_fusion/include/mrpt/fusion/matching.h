// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/association.h>
#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/optimization.h>
#include <mrpt/fusion/search.h>
#include <mrpt/fusion/voxels.h>

#include <Eigen/Geometry>
#include <functional>
#include <vector>

/** \file The paper's Sec. IV-A: two-level probabilistic map matching (PMM), edges, then voxels. */

namespace mrpt::fusion {

/** What matching needs of a map; computed once per map. */
struct MapFeatures {
  const octomap::OcTree* map = nullptr;  ///< not owned, must outlive the features
  OccupiedVoxels voxels;
  Surfaces surfaces;  ///< of the voxels
  EdgeVoxels edges;
};
MapFeatures computeFeatures(const octomap::OcTree& map, const EdgeParams& params);

struct LevelParams {
  unsigned max_iterations = 30;
  double gate = 2.0;  ///< pairs are closer than this by the level's descriptor distance, m
  /** The gate shrinks to this, by a fifth each iteration, m; as published: the gate itself. */
  double final_gate = 2.0;
};

/** What the voxel level minimises. */
enum class VoxelMetric {
  Point,   ///< eq. (22), as published: distance between voxels
  Surface  ///< distance between the surfaces they are pieces of, see linearizeSurfaces()
};

struct MatchParams {
  EdgeParams edges;
  SearchParams search;
  WeightParams weights;
  /** Unit of eq. (4) beside eq. (6) at the edge level. */
  VoxelCovariance voxel_covariance = VoxelCovariance::Plain;
  LevelParams edge_level{30, 2.0, 2.0};   ///< Table I
  LevelParams voxel_level{30, 0.5, 0.2};  ///< gate: Table I; never below two voxels
  VoxelMetric voxel_metric = VoxelMetric::Surface;
  double flatness = 0.01;  ///< of a surface voxel: variance across over variance along it
  /** A level has converged when an iteration moves the pose by less than both. */
  double min_step_translation = 1e-4;  ///< m
  double min_step_rotation = 1e-4;     ///< rad
};

enum class Level { Edge = 1, Voxel = 2 };

/** One iteration: an association and the optimisation that follows it. */
struct IterationRecord {
  Level level;
  size_t pairs;
  double mse;               ///< of the association's pairs, m^2
  double step_translation;  ///< m
  double step_rotation;     ///< rad
  Eigen::Isometry3d T_a_b;  ///< the pose it reached
};

struct MatchResult {
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();
  /** Of a left perturbation (translation, rotation); huge as long as nothing is known. */
  Matrix6d covariance = 1e6 * Matrix6d::Identity();
  std::vector<IterationRecord> iterations;
  Pairs pairs;  ///< of voxels at T_a_b, see pairVoxels()
  /** Fewer than this many pairs tell nothing, and no level goes on with them. */
  static constexpr size_t kMinPairs = 10;
  bool hasPairs() const { return pairs.size() >= kMinPairs; }
};

using OnIteration = std::function<void(const IterationRecord&)>;

/** Eqs. (10)-(12): the pose of map B (scene) in A's frame (model) that brings B's edges, then B's
 * voxels, onto A's, from an initial guess.
 *
 * A local optimiser: it finds the nearest minimum. Whether that is the pose is for evaluateMatch()
 * to say. Without pairs within the gates it returns the guess and no pairs. Deterministic, whatever
 * the number of threads.
 *
 * \param[in] on_iteration Called after each iteration, if given (progress, plots).
 * Cost: iterations * scene voxels * log(model voxels).
 */
MatchResult matchTwoLevel(const MapFeatures& a, const MapFeatures& b,
                          const Eigen::Isometry3d& T_a_b, const MatchParams& params,
                          const OnIteration& on_iteration = {});

/** Some of a map's voxels, spread evenly: in each cube of the octree that is at least \a spacing
 * (m) wide the one most likely occupied of those with a normal, if any. Edges and map are the same.
 * O(voxels). */
MapFeatures thinOut(const MapFeatures& features, double spacing);

/** As matchTwoLevel(), but from several starts (not in the paper): the guess carried through the
 * edge level, and the best poses that searchAround() finds near it. Each is refined on a few of B's
 * voxels; the one where the maps then agree best, see agreement(), goes through the voxel level.
 * Without a search (params.search.translation = 0) it is matchTwoLevel(). */
MatchResult matchMaps(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b,
                      const MatchParams& params, const OnIteration& on_iteration = {});

/** How well two maps agree at a pose: obstacles of each that the other confirms, less those that
 * lie in the other's free space. */
double agreement(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b);

/** The voxel pairs at a given pose, weighted and gated as the voxel level begins: what
 * evaluateMatch() judges. */
Pairs pairVoxels(const OccupiedVoxels& a, const OccupiedVoxels& b, const Eigen::Isometry3d& T_a_b,
                 const MatchParams& params);

}  // namespace mrpt::fusion
