// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/voxels.h>

#include <Eigen/Geometry>
#include <functional>
#include <utility>
#include <vector>

#include "fusion_core/registration/association.h"
#include "fusion_core/registration/optimization.h"
#include "fusion_core/search/search.h"

/** \file
 * The paper's Sec. IV-A: two-level probabilistic map matching (PMM), edges, then voxels. */

namespace mrpt::fusion {

struct MatchParams;

/** What matching needs of a map; computed once per map. */
struct MapFeatures : MapVoxels {
  SurfaceVoxels matched;  ///< the voxels that the levels work on
  EdgeVoxels edges;       ///< the structural edges, for the edge level
};
/** Extracts them; \a map must outlive the result. Cost: see extractEdges(). */
MapFeatures computeFeatures(const octomap::OcTree& map, const MatchParams& params);
/** What matching by edges alone needs: they are the matched voxels, without normals.
 * \param[in] map All that is known of occupied and free space, which may be the edges only.
 * \param[in] edge_tree The edges, occupied. \param[in] edges The same with their directions. */
MapFeatures featuresOfEdges(const octomap::OcTree& map, const octomap::OcTree& edge_tree,
                            const EdgeVoxels& edges);
/** Indices of the matched voxels in which computeFeatures() looks for edges. */
std::vector<uint32_t> edgeCandidates(const SurfaceVoxels& matched, const MatchParams& params);
/** \overload
 * For two maps at once. */
std::pair<MapFeatures, MapFeatures> computeFeatures(const octomap::OcTree& map_a,
                                                    const octomap::OcTree& map_b,
                                                    const MatchParams& params);

/** Settings of one of the two levels. */
struct LevelParams {
  unsigned max_iterations = 30;  ///< associations at most
  double gate = 2.0;  ///< pairs are closer than this by the level's descriptor distance, m
  /** The gate shrinks to this, by a fifth when an iteration moves b less than a twentieth of it, m;
   * as published: the gate itself. */
  double final_gate = 2.0;
};

/** What the voxel level minimises. */
enum class VoxelMetric {
  Point,   ///< eq. (22), as published: distance between voxels
  Surface  ///< distance between the surfaces they are pieces of, see linearizeSurfaces()
};

/** Settings of matchMaps() and matchTwoLevel(). */
struct MatchParams {
  EdgeParams edges;  ///< Algorithm 1
  /** The levels work on one voxel in each cube of the octree that is at least this wide, the most
   * likely occupied one, which counts for all of them (not in the paper, which takes all: 0), m. */
  double voxel_spacing = 0.2;
  /** Edges are looked for where the surface bends most in each cube of the octree that is at least
   * this wide (not in the paper; 0: everywhere), m. They tell one of the starts of a search well
   * enough; the edge level alone needs all that there are. */
  double edge_spacing = 0.4;
  SearchParams search;   ///< for starts around the guess
  WeightParams weights;  ///< of the descriptors
  /** Unit of eq. (4) beside eq. (6) at the edge level. */
  VoxelCovariance voxel_covariance = VoxelCovariance::Plain;
  LevelParams edge_level{30, 2.0, 0.8};             ///< gate: Table I
  LevelParams voxel_level{30, 0.5, 0.2};            ///< gate: Table I; never below two voxels
  VoxelMetric voxel_metric = VoxelMetric::Surface;  ///< what the voxel level minimises
  double flatness = 0.01;  ///< of a surface voxel: variance across over variance along it
  /** One step: the pairs change before a second one would tell. */
  SolverParams solver{1, 1e-5, 1e-5};
  /** Of each map, spread evenly: those that are paired at the end, and the verdict asks (not in the
   * paper, which takes all: 0). */
  unsigned evaluation_voxels = kVoxelsOfVerdict;
  /** A level has converged when an iteration moves the pose by less than both. */
  double min_step_translation = 1e-3;  ///< m
  double min_step_rotation = 1e-4;     ///< rad
};

/** The levels of matching, in their order. */
enum class Level {
  Edge = 1,  ///< structural edges, eq. (21)
  Voxel = 2  ///< occupied voxels, eq. (22)
};

/** One iteration: an association and the optimisation that follows it. */
struct IterationRecord {
  Level level;              ///< of the iteration
  size_t pairs;             ///< associated
  double mse;               ///< of the association's pairs, m^2
  double step_translation;  ///< of the middle of the level's scene, m
  double step_rotation;     ///< rad
  Eigen::Isometry3d T_a_b;  ///< the pose it reached
};

/** A pose that was compared with others. */
struct RankedPose {
  Eigen::Isometry3d T_a_b;  ///< pose of map B in A's frame
  double agreement;         ///< see agreement()
  /** As MatchResult::covariance, from the few voxels that it was refined on; huge if the maps agree
   * less than a twentieth as well as at the best pose. */
  Matrix6d covariance;
};

/** What matching found. */
struct MatchResult {
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< pose of map B in A's frame
  /** Of a left perturbation (translation, rotation); huge as long as nothing is known. */
  Matrix6d covariance = 1e6 * Matrix6d::Identity();
  std::vector<IterationRecord> iterations;  ///< in their order
  /** The poses that were compared, 0.6 m or 6 deg apart, by agreement(), best first: T_a_b is the
   * first, refined on all voxels. None without a search. One that judgeMatch() finds is second; so
   * may be one that all voxels left for T_a_b. */
  std::vector<RankedPose> hypotheses;
  /** Agreement of the second hypothesis over that of the first; 0 if there is none. In [0,1] but
   * for such a second one. */
  double runnerUp() const {
    return hypotheses.size() > 1 && hypotheses[0].agreement > 0
               ? hypotheses[1].agreement / hypotheses[0].agreement
               : 0;
  }
  Pairs pairs;  ///< of voxels at T_a_b, see pairVoxels()
  /** Fewer than this many pairs tell nothing, and no level goes on with them. */
  static constexpr size_t kMinPairs = 10;
  /** True if there are enough pairs to go by. */
  bool hasPairs() const { return pairs.size() >= kMinPairs; }
};

using OnIteration = std::function<void(const IterationRecord&)>;  ///< see matchTwoLevel()

/** Eqs. (10)-(12): the pose of map B (scene) in A's frame (model) that brings B's edges, then B's
 * voxels, onto A's, from an initial guess.
 *
 * A local optimiser: it finds the nearest minimum. Whether that is the pose is for evaluateMatch()
 * to say. Without pairs within the gates it returns the guess and no pairs. Deterministic, whatever
 * the number of threads.
 *
 * \param[in] a,b Features of the maps A and B. \param[in] T_a_b The guess. \param[in] params All
 * of it but the search. \param[in] on_iteration Called after each iteration, if given (progress,
 * plots); never by two threads at a time, but not always by the same one.
 * Cost: iterations * scene voxels * log(model voxels).
 */
MatchResult matchTwoLevel(const MapFeatures& a, const MapFeatures& b,
                          const Eigen::Isometry3d& T_a_b, const MatchParams& params,
                          const OnIteration& on_iteration = {});

/** Some of a map's voxels. */
struct Thinned {
  std::vector<uint32_t> index;  ///< ascending
  std::vector<float> weight;    ///< how many voxels each stands for
};
/** Some of a map's voxels, spread evenly: in each cube of the octree that is at least \a spacing
 * (m) wide the most likely occupied one, for all of them. O(voxels). */
Thinned thinOut(const OccupiedVoxels& voxels, double spacing);
/** \overload
 * With `is_better(i, j) -> bool` to choose another than the most likely occupied one. */
template <class IsBetter>
Thinned thinOut(const OccupiedVoxels& voxels, double spacing, IsBetter&& is_better);

/** As matchTwoLevel(), but from several starts (not in the paper): the guess carried through the
 * edge level, and the best poses that searchAround() finds near it. Each is refined on a few
 * voxels, many of them on fewer first; the one where the maps then agree best, see agreement(),
 * goes through the voxel level. Where this comes to another pose, that one is compared with the
 * others as well.
 * Without a search (params.search.translation = 0) it is matchTwoLevel(). */
MatchResult matchMaps(const MapFeatures& a, const MapFeatures& b, const Eigen::Isometry3d& T_a_b,
                      const MatchParams& params, const OnIteration& on_iteration = {});

/** The verdict on a match: evaluateMatch(), with the hypotheses that matchMaps() has compared.
 *
 * A search around a guess does not see what lies beyond its reach, and a guess may be wrong. A
 * match that is accepted, but not as EvaluationParams::sure_probability, is compared with the best
 * pose of a search from everywhere() (not in the paper). If the maps agree clearly better there, by
 * EvaluationParams::max_runner_up, that pose becomes the second of result.hypotheses, and the match
 * is rejected. \param[in] a,b Features of the maps A and B. \param[in] params As for matchMaps().
 * \param[in] evaluation What is accepted. \param[in,out] result Of matchMaps(), or a pose and its
 * pairs. Such a comparison costs what matchMaps() costs without a guess. */
Evaluation judgeMatch(const MapFeatures& a, const MapFeatures& b, const MatchParams& params,
                      const EvaluationParams& evaluation, MatchResult& result);

/** Some of a map's obstacles, to compare poses with. */
struct Obstacles {
  std::vector<Eigen::Vector3f> centre;  ///< m, map frame
  /** Unit normal of the obstacle's surface towards the free space before it; zero where the map has
   * seen it from both sides, or knows no free space there. */
  std::vector<Eigen::Vector3f> front;
};
/** The obstacles that a map's surface voxels are, with the side from which it has seen them. */
Obstacles obstaclesOf(const MapVoxels& map, const SurfaceVoxels& voxels);

/** How well two maps agree at a pose, by some obstacles of each (not in the paper): how many of
 * them the other map confirms, times exp(-r / 0.02) where a share r of those that it can tell of
 * lies in its free space. The right pose has few of these (0 to 7 % on all our maps), while a wrong
 * one may well have the larger overlap. An obstacle is confirmed in full by one that is seen from
 * the same side, else in part: a floor on a ceiling, or two rooms back to back, contradict nothing.
 */
double agreement(const MapVoxels& a, const Obstacles& of_a, const MapVoxels& b,
                 const Obstacles& of_b, const Eigen::Isometry3d& T_a_b);

/** The voxel pairs at a given pose, weighted and gated as the voxel level begins: what
 * evaluateMatch() judges. Of params.evaluation_voxels of b's voxels, see strideFor(). */
Pairs pairVoxels(const MapVoxels& a, const MapVoxels& b, const Eigen::Isometry3d& T_a_b,
                 const MatchParams& params);

// ------------------------------------------------------------------------------------------------

template <class IsBetter>
Thinned thinOut(const OccupiedVoxels& voxels, double spacing, IsBetter&& is_better) {
  unsigned shift = 0;
  while (voxels.resolution * (1U << shift) < spacing * (1 - 1e-9) && shift < 15) shift++;
  const auto sameCube = [&](size_t i, size_t j) {
    const octomap::OcTreeKey &a = voxels.key[i], &b = voxels.key[j];
    return a[0] >> shift == b[0] >> shift && a[1] >> shift == b[1] >> shift &&
           a[2] >> shift == b[2] >> shift;
  };
  Thinned kept;
  const auto n = static_cast<uint32_t>(voxels.size());
  for (uint32_t i = 0, next; i < n; i = next) {
    uint32_t best = i;  // in the order of the octree's leaves a cube's voxels follow each other
    for (next = i + 1; next < n && sameCube(i, next); next++)
      if (is_better(next, best)) best = next;
    kept.index.push_back(best);
    kept.weight.push_back(static_cast<float>(next - i));
  }
  return kept;
}

}  // namespace mrpt::fusion
