// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Measures what two maps of a team say for and against a pose. */
#include "fusion_team/pairs/pair_evidence.h"

#include <algorithm>
#include <utility>

#include "fusion_core/features/features.h"
#include "fusion_core/pair/match.h"
#include "fusion_core/pair/scaled_options.h"

namespace mrpt::fusion {
namespace {

/** Largest motion of a pose to the refined pose, share of the tolerance of a right pose. With more,
 * each pair of a pile of maps would find a pose of its own. */
constexpr double kSlack = 0.2;
/** Contradicted obstacles over confirmed obstacles at which no refinement helps. */
constexpr double kHopeless = 0.1;
/** Largest difference of two poses that share their evidence, share of the tolerance. */
constexpr double kSameQuestion = 0.1;
/** Largest distance of a displaced obstacle from an obstacle of the other map, share of the
 * tolerance of a right pose. Drift bends maps by so much. */
constexpr double kDisplacement = 0.7;

Eigen::AlignedBox3d boxOf(const MapFeatures& map) {
  Eigen::AlignedBox3d box;
  for (const auto& p : map.matched.voxels.centre) box.extend(p.cast<double>());
  return box;
}

/** Compares the obstacles of a map with another map.
 * \param[in] map The other map.
 * \param[in] near Obstacles that are so near are displaced.
 * \param[in] obstacles Obstacles of a map with voxels of size \a resolution, m.
 * \param[in] T Pose of the map of the obstacles in the frame of \a map. */
ComparedObstacles compared(const MapFeatures& map, const VoxelBlocks::Ball& near,
                           const Obstacles& obstacles, double resolution,
                           const Eigen::Isometry3d& T, const AgreementParams& params) {
  const double before = params.front_voxels * std::max(resolution, map.voxels.resolution);
  const size_t words = (obstacles.centre.size() + 63) / 64;
  ComparedObstacles result{ObstacleSet(words), ObstacleSet(words), ObstacleSet(words)};
  for (size_t i = 0; i < obstacles.centre.size(); i++) {
    const ObstacleCheck check = checkFromSameSide(map, obstacles, i, before, T);
    const uint64_t bit = uint64_t{1} << (i % 64);
    if (check == ObstacleCheck::Confirmed) result.confirmed[i / 64] |= bit;
    if (check != ObstacleCheck::Conflicting) continue;
    const bool is_near = hasObstacle(map, T * obstacles.centre[i].cast<double>(), near);
    (is_near ? result.displaced : result.contradicted)[i / 64] |= bit;
  }
  return result;
}

/** Returns the confirmed obstacles less the contradicted obstacles, each contradicted obstacle
 * weighed by 1 / tolerance. */
double scoreOf(const PairEvidence& e, double tolerance) {
  return e.confirmed() - (e.displaced() + e.contradicted()) / tolerance;
}

}  // namespace

double countOf(const ObstacleSet& set) {
  size_t n = 0;
  for (const uint64_t word : set) n += static_cast<size_t>(__builtin_popcountll(word));
  return static_cast<double>(n);
}

struct EvidenceOfPair::Comparison {
  Comparison(const MapFeatures& a, const MapFeatures& b, const Options& options)
      : association(associationOf(a, b, options.registration)),
        by_many(a, b, association, comparisonOf(options), options.ranking.many_voxels),
        near_in_a(ballIn(a, options)),
        near_in_b(ballIn(b, options)) {}

  static VoxelBlocks::Ball ballIn(const MapFeatures& map, const Options& options) {
    constexpr double kLeast = 2;  // voxels; a nearer obstacle is no conflict
    const double radius = kDisplacement * options.evaluation.tolerance.translation;
    return VoxelBlocks::Ball(std::max(kLeast, radius / map.voxels.resolution));
  }

  VoxelAssociation association;
  PoseComparison by_many;
  VoxelBlocks::Ball near_in_a, near_in_b;  // places of displaced obstacles
};

EvidenceOfPair::EvidenceOfPair(const PreparedMap& a, const PreparedMap& b, const Options& options)
    : a_(a),
      b_(b),
      options_(scaledBy(options, std::max(a.scale(), b.scale()))),
      box_a_(boxOf(a.features())),
      box_b_(boxOf(b.features())),
      middle_b_(meanOf(b.features().matched.voxels.centre)) {}

EvidenceOfPair::~EvidenceOfPair() = default;

bool EvidenceOfPair::isSame(const Eigen::Isometry3d& T, const Eigen::Isometry3d& U,
                            double factor) const {
  PoseTolerance tolerance = options_.evaluation.tolerance;
  tolerance.translation *= factor;
  tolerance.rotation *= factor;
  return isSamePlace(T, U, middle_b_, tolerance);
}

bool EvidenceOfPair::mayMeet(const Eigen::Isometry3d& T_a_b) const {
  return box_a_.intersects(box_b_.transformed(T_a_b));
}

PairEvidence EvidenceOfPair::at(const Eigen::Isometry3d& T_a_b) const {
  const MapFeatures &a = a_.features(), &b = b_.features();
  const AgreementParams& params = options_.ranking.agreement;
  const PoseComparison& c = comparison_->by_many;
  return {
      T_a_b, T_a_b,
      compared(b, comparison_->near_in_b, c.obstaclesOfA(), a.voxels.resolution, T_a_b.inverse(),
               params),
      compared(a, comparison_->near_in_a, c.obstaclesOfB(), b.voxels.resolution, T_a_b, params)};
}

bool EvidenceOfPair::answers(const Known& known, const Eigen::Isometry3d& T_a_b) const {
  const double factor = known.is_refined ? kSlack : kSameQuestion;
  const double most = factor * options_.evaluation.tolerance.translation;
  return (T_a_b * middle_b_ - known.middle).squaredNorm() <= most * most &&  // cheap
         isSame(T_a_b, known.evidence.T_a_b, factor);
}

EvidenceOfPair::Known EvidenceOfPair::computed(const Eigen::Isometry3d& T_a_b) {
  if (!comparison_)
    comparison_ = std::make_unique<Comparison>(a_.features(), b_.features(), options_);
  Known as_asked{T_a_b * middle_b_, false, at(T_a_b), T_a_b};
  if (as_asked.evidence.contradicted() >= kHopeless * as_asked.evidence.confirmed())
    return as_asked;
  const Eigen::Isometry3d refined = comparison_->by_many.refined(T_a_b).T_a_b;
  if (isSame(T_a_b, refined)) as_asked.evidence.registered = refined;
  if (!isSame(T_a_b, refined, kSlack)) return as_asked;
  PairEvidence there = at(refined);
  const double tolerance = options_.ranking.agreement.tolerance;
  if (scoreOf(there, tolerance) <= scoreOf(as_asked.evidence, tolerance)) return as_asked;
  return {refined * middle_b_, true, std::move(there), T_a_b};
}

EvidenceOfPair::Known EvidenceOfPair::rememberedOrComputed(const Eigen::Isometry3d& T_a_b) {
  for (const Known& known : before_)
    if (known.asked.matrix() == T_a_b.matrix()) return known;
  return computed(T_a_b);
}

void EvidenceOfPair::restart() {
  const std::lock_guard<std::mutex> lock(mutex_);
  before_ = std::exchange(known_, {});
}

const PairEvidence& EvidenceOfPair::near(const Eigen::Isometry3d& T_a_b) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const Known& known : known_)
    if (answers(known, T_a_b)) return known.evidence;
  if (mayMeet(T_a_b))
    known_.push_back(rememberedOrComputed(T_a_b));
  else
    known_.push_back({T_a_b * middle_b_, false, {T_a_b, T_a_b, {}, {}}, T_a_b});
  return known_.back().evidence;
}

}  // namespace mrpt::fusion
