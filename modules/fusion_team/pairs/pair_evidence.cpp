// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Measures what two maps of a team say for and against a pose. */
#include "fusion_team/pairs/pair_evidence.h"

#include <algorithm>

#include "fusion_core/features/features.h"
#include "fusion_core/pair/match.h"
#include "fusion_core/pair/scaled_options.h"

namespace mrpt::fusion {
namespace {

/** Largest motion of a pose to the refined pose, share of the tolerance of a right pose. With more,
 * each pair of a pile of maps would find a pose of its own. */
constexpr double kSlack = 0.2;
/** Largest difference of two poses that share their evidence, share of the tolerance. */
constexpr double kSameQuestion = 0.1;

Eigen::AlignedBox3d boxOf(const MapFeatures& map) {
  Eigen::AlignedBox3d box;
  for (const auto& p : map.matched.voxels.centre) box.extend(p.cast<double>());
  return box;
}

ComparedObstacles compared(const MapFeatures& map, const Obstacles& obstacles, double resolution,
                           const Eigen::Isometry3d& T, const AgreementParams& params) {
  const double before = params.front_voxels * std::max(resolution, map.voxels.resolution);
  const size_t words = (obstacles.centre.size() + 63) / 64;
  ComparedObstacles result{ObstacleSet(words), ObstacleSet(words)};
  for (size_t i = 0; i < obstacles.centre.size(); i++) {
    const ObstacleCheck check = checkFromSameSide(map, obstacles, i, before, T);
    const uint64_t bit = uint64_t{1} << (i % 64);
    if (check == ObstacleCheck::Confirmed) result.confirmed[i / 64] |= bit;
    if (check == ObstacleCheck::Conflicting) result.contradicted[i / 64] |= bit;
  }
  return result;
}

/** Returns the confirmed obstacles less the contradicted obstacles, each contradicted obstacle
 * weighed by 1 / tolerance. */
double scoreOf(const PairEvidence& e, double tolerance) {
  const auto n = [](const ObstacleSet& a, const ObstacleSet& b) { return countOf(a) + countOf(b); };
  return n(e.of_a.confirmed, e.of_b.confirmed) -
         n(e.of_a.contradicted, e.of_b.contradicted) / tolerance;
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
        by_many(a, b, association, comparisonOf(options), options.ranking.many_voxels) {}

  VoxelAssociation association;
  PoseComparison by_many;
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
  return {T_a_b, compared(b, c.obstaclesOfA(), a.voxels.resolution, T_a_b.inverse(), params),
          compared(a, c.obstaclesOfB(), b.voxels.resolution, T_a_b, params)};
}

PairEvidence EvidenceOfPair::computed(const Eigen::Isometry3d& T_a_b) {
  if (!comparison_)
    comparison_ = std::make_unique<Comparison>(a_.features(), b_.features(), options_);
  PairEvidence here = at(T_a_b);
  if (countOf(here.of_a.confirmed) + countOf(here.of_b.confirmed) == 0) return here;
  const Eigen::Isometry3d refined = comparison_->by_many.refined(T_a_b).T_a_b;
  if (!isSame(T_a_b, refined, kSlack)) return here;
  PairEvidence there = at(refined);
  const double tolerance = options_.ranking.agreement.tolerance;
  return scoreOf(there, tolerance) > scoreOf(here, tolerance) ? there : here;
}

const PairEvidence& EvidenceOfPair::near(const Eigen::Isometry3d& T_a_b) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const Known& known : known_)
    if (isSame(known.asked, T_a_b, kSameQuestion)) return known.evidence;
  known_.push_back({T_a_b, mayMeet(T_a_b) ? computed(T_a_b) : PairEvidence{T_a_b, {}, {}}});
  return known_.back().evidence;
}

}  // namespace mrpt::fusion
