// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Measures what two maps of a team say for and against a pose. */
#include "fusion_team/pairs/pair_evidence.h"

#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <utility>

#include "fusion_base/bits.h"
#include "fusion_core/features/features.h"
#include "fusion_core/pair/match.h"
#include "fusion_core/pair/scaled_options.h"

namespace mrpt::fusion {
namespace {

/** Contradicted obstacles over confirmed obstacles at which no refinement helps. */
constexpr double kHopeless = 0.1;
/** Least share of the compared obstacles that must be confirmed to fix a pose. Fewer obstacles are
 * a patch of floor and walls, which slides along a corridor. */
constexpr double kLeastConfirmed = 0.1;
/** Largest distance of a displaced obstacle from an obstacle of the other map, share of the
 * tolerance of a right pose. Drift bends maps by so much. */
constexpr double kDisplacement = 0.7;

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
  for (const uint64_t word : set) n += static_cast<size_t>(countBits(word));
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

  double obstacles() const {
    const auto n = by_many.obstaclesOfA().centre.size() + by_many.obstaclesOfB().centre.size();
    return static_cast<double>(n);
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

template <class Value>
template <class Make>
const Value& EvidenceOfPair::Memo<Value>::at(const Eigen::Isometry3d& T, const Make& make) {
  Key key;
  Eigen::Map<Eigen::Matrix4d>(key.data()) = T.matrix();
  const auto known = values_.find(key);
  if (known != values_.end()) return known->second;
  const auto before = before_.find(key);
  return values_.emplace(key, before != before_.end() ? std::move(before->second) : make())
      .first->second;
}

const PairEvidence& EvidenceOfPair::at(const Eigen::Isometry3d& T_a_b) {
  return compared_.at(T_a_b, [&] {
    const MapFeatures &a = a_.features(), &b = b_.features();
    const AgreementParams& params = options_.ranking.agreement;
    const PoseComparison& c = comparison_->by_many;
    PairEvidence e{T_a_b, {}, {}};
    tbb::parallel_invoke(
        [&] {
          e.of_a = compared(b, comparison_->near_in_b, c.obstaclesOfA(), a.voxels.resolution,
                            T_a_b.inverse(), params);
        },
        [&] {
          e.of_b = compared(a, comparison_->near_in_a, c.obstaclesOfB(), b.voxels.resolution, T_a_b,
                            params);
        });
    return e;
  });
}

std::optional<Eigen::Isometry3d> EvidenceOfPair::registeredNear(const Eigen::Isometry3d& T_a_b) {
  for (const Eigen::Isometry3d& known : registered_)
    if (isSame(T_a_b, known)) return known;
  const Eigen::Isometry3d& refined =
      refined_.at(T_a_b, [&] { return comparison_->by_many.refined(T_a_b).T_a_b; });
  if (!isSame(T_a_b, refined)) return std::nullopt;
  registered_.push_back(refined);
  return refined;
}

bool EvidenceOfPair::answers(const Known& known, const Eigen::Isometry3d& T_a_b) const {
  return isSame(T_a_b, known.evidence.T_a_b, kSharedEvidence);
}

EvidenceOfPair::Known EvidenceOfPair::computed(const Eigen::Isometry3d& T_a_b) {
  if (!comparison_)
    comparison_ = std::make_unique<Comparison>(a_.features(), b_.features(), options_);
  Known as_asked{T_a_b * middle_b_, at(T_a_b)};
  const double confirmed = as_asked.evidence.confirmed();
  if (as_asked.evidence.contradicted() >= kHopeless * confirmed ||
      confirmed < kLeastConfirmed * comparison_->obstacles())
    return as_asked;
  const auto registered = registeredNear(T_a_b);
  as_asked.evidence.registered = registered;
  if (!registered || !isSame(T_a_b, *registered, kSharedEvidence)) return as_asked;
  const PairEvidence& there = at(*registered);
  const double tolerance = options_.ranking.agreement.tolerance;
  if (scoreOf(there, tolerance) <= scoreOf(as_asked.evidence, tolerance)) return as_asked;
  Known refined{*registered * middle_b_, there};
  refined.evidence.registered = registered;
  return refined;
}

size_t EvidenceOfPair::Hash::operator()(const Eigen::Vector3i& cell) const {
  const auto bits = [&](int i) { return static_cast<uint64_t>(static_cast<uint32_t>(cell[i])); };
  return (bits(0) * 0x9e3779b97f4a7c15) ^ (bits(1) * 0xc2b2ae3d27d4eb4f) ^
         (bits(2) * 0x165667b19e3779f9);
}

Eigen::Vector3i EvidenceOfPair::cellOf(const Eigen::Vector3d& middle) const {
  const double side = 2 * kSharedEvidence * options_.evaluation.tolerance.translation;
  return (middle / side).array().floor().cast<int>();
}

void EvidenceOfPair::remember(Known known) {
  // It is found from all cells with a place that it may answer.
  const double reach = kSharedEvidence * options_.evaluation.tolerance.translation;
  const Eigen::Vector3d corner = Eigen::Vector3d::Constant(reach);
  const Eigen::Vector3i first = cellOf(known.middle - corner), last = cellOf(known.middle + corner);
  for (int x = first.x(); x <= last.x(); x++)
    for (int y = first.y(); y <= last.y(); y++)
      for (int z = first.z(); z <= last.z(); z++)
        known_in_[Eigen::Vector3i(x, y, z)].push_back(known_.size());
  known_.push_back(std::move(known));
}

void EvidenceOfPair::restart() {
  const std::lock_guard<std::mutex> lock(mutex_);
  known_.clear();
  known_in_.clear();
  registered_.clear();
  compared_.restart();
  refined_.restart();
  covariance_.restart();
}

Matrix6d EvidenceOfPair::covarianceAt(const Eigen::Isometry3d& registered) {
  const std::lock_guard<std::mutex> lock(mutex_);
  return tbb::this_task_arena::isolate([&] {
    return covariance_.at(registered,
                          [&] { return comparison_->by_many.covarianceAt(registered); });
  });
}

const PairEvidence& EvidenceOfPair::near(const Eigen::Isometry3d& T_a_b) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto in_cell = known_in_.find(cellOf(T_a_b * middle_b_));
  if (in_cell != known_in_.end())
    for (const size_t i : in_cell->second)
      if (answers(known_[i], T_a_b)) return known_[i].evidence;
  if (mayMeet(T_a_b))
    remember(tbb::this_task_arena::isolate([&] { return computed(T_a_b); }));
  else
    remember({T_a_b * middle_b_, {T_a_b, {}, {}}});
  return known_.back().evidence;
}

}  // namespace mrpt::fusion
