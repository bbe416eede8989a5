// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Finds pairs of voxels and of edge voxels, eqs. (13)-(20). */
#include "fusion_core/registration/association.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "fusion_base/parallel.h"
#include "fusion_base/remembered_function.h"
#include "fusion_core/map/kd_tree.h"
#include "fusion_core/map/voxel_search.h"

namespace mrpt::fusion {

double occupancyUncertainty(const std::vector<float>& probability_a,
                            const std::vector<float>& probability_b) {
  double sum = 0;
  RememberedFunction term([](float p) { return p > 0 ? p * std::log(static_cast<double>(p)) : 0; });
  for (const auto* probabilities : {&probability_a, &probability_b})
    for (const float p : *probabilities) sum -= term(p);
  const size_t n = probability_a.size() + probability_b.size();
  return n > 0 ? sum / static_cast<double>(n) : 0;
}

double structuralUncertainty(const EdgeVoxels& a, const EdgeVoxels& b) {
  double sum = 0;
  for (const auto* edges : {&a, &b})
    for (const auto& c : edges->covariance) sum += c.linearity();
  const size_t n = a.size() + b.size();
  return n > 0 ? sum / static_cast<double>(n) : 0;
}

double meanSquaredError(const Pairs& pairs) {
  double sum = 0;
  for (const Pair& p : pairs) sum += p.squared_distance;
  return pairs.empty() ? 0 : sum / static_cast<double>(pairs.size());
}

DescriptorWeights descriptorWeights(double mse, double H_m, double lambda_tau,
                                    const WeightParams& params) {
  constexpr double kLeastUncertainty = 1e-3;
  return {params.k1 * mse / std::max(H_m, kLeastUncertainty), params.k2 * mse * lambda_tau};
}

namespace {

constexpr uint32_t kUnpaired = ~uint32_t{0};

/** Associates each of n voxels of B, in parallel, and keeps the pairs found. If \a among is given,
 * only the voxels of B in these pairs are associated. */
template <class FindModel>
Pairs associateEach(size_t n, const Pairs* among, FindModel&& find) {
  Pairs pairs(among ? among->size() : n);
  forEachIndex(pairs.size(), kGrain, [&](size_t i) {
    pairs[i] = find(among ? (*among)[i].b : static_cast<uint32_t>(i));
  });
  pairs.erase(
      std::remove_if(pairs.begin(), pairs.end(), [](const Pair& p) { return p.a == kUnpaired; }),
      pairs.end());
  return pairs;
}

}  // namespace

struct VoxelAssociation::Impl {
  explicit Impl(const OccupiedVoxels& m) : a(m), search(m.centre, m.resolution) {}
  Impl(const OccupiedVoxels& m, const VoxelBlocks& blocks)
      : a(m), search(m.centre, m.resolution, blocks) {}

  const OccupiedVoxels& a;
  VoxelSearch search;
};

VoxelAssociation::VoxelAssociation(const OccupiedVoxels& a) : impl_(new Impl(a)) {}
VoxelAssociation::VoxelAssociation(const OccupiedVoxels& a, const VoxelBlocks& blocks)
    : impl_(new Impl(a, blocks)) {}
VoxelAssociation::~VoxelAssociation() = default;
VoxelAssociation::VoxelAssociation(VoxelAssociation&&) noexcept = default;

void VoxelAssociation::prepare(double gate) { impl_->search.prepare(gate); }

Pairs VoxelAssociation::associate(const OccupiedVoxels& b, const Eigen::Isometry3d& T_a_b,
                                  const DescriptorWeights& weights, double gate, const Pairs* among,
                                  Partners* last) {
  prepare(gate);
  return std::as_const(*this).associate(b, T_a_b, weights, gate, among, last);
}

Pairs VoxelAssociation::associate(const OccupiedVoxels& b, const Eigen::Isometry3d& T_a_b,
                                  const DescriptorWeights& weights, double gate, const Pairs* among,
                                  Partners* last) const {
  if (gate > impl_->search.gate())
    throw std::logic_error("VoxelAssociation: a gate wider than prepared for");
  const Eigen::Isometry3f T = T_a_b.cast<float>();
  const auto gate2 = static_cast<float>(gate * gate);
  const auto w_o = static_cast<float>(weights.omega_o);
  const OccupiedVoxels& a = impl_->a;
  if (last && last->size() != b.size()) last->assign(b.size(), {});
  constexpr float kRounding = 1e-5F;
  return associateEach(b.size(), among, [&](uint32_t i) {
    const Eigen::Vector3f p = T * b.centre[i];
    const float probability = b.probability[i];
    const auto byOccupancy = [&](uint32_t m) {
      const float dp = a.probability[m] - probability;
      return w_o * dp * dp;
    };
    VoxelSearch::Nearest best{VoxelSearch::kNone, gate2};
    bool is_known = false;
    if (last) {
      const Partner& known = (*last)[i];
      const float others = (known.others - (known.place - p).norm()) * (1 - kRounding);
      const bool has_partner = known.a != VoxelSearch::kNone;
      const float again =
          has_partner ? (a.centre[known.a] - p).squaredNorm() + byOccupancy(known.a) : gate2;
      if (has_partner && again < gate2) best = {known.a, again};
      is_known = others > 0 && std::min(again, gate2) < others * others;
    }
    if (!is_known) {
      best = impl_->search.nearest(p, best, byOccupancy);
      if (last) (*last)[i] = {best.index, std::sqrt(best.others), p};
    }
    if (best.index == VoxelSearch::kNone) return Pair{kUnpaired, i, 0};
    return Pair{best.index, i, (a.centre[best.index] - p).squaredNorm()};
  });
}

struct EdgeAssociation::Impl {
  KdTree<7> tree;
};

EdgeAssociation::EdgeAssociation(const EdgeVoxels& a) {
  std::vector<KdTree<7>::Descriptor> descriptors(a.size());
  for (size_t i = 0; i < a.size(); i++) {
    const auto& c = a.centre[i];
    const Eigen::Vector3f tau = a.covariance[i].direction().cast<float>();
    descriptors[i] = {c.x(), c.y(), c.z(), a.probability[i], tau.x(), tau.y(), tau.z()};
  }
  impl_.reset(new Impl{KdTree<7>(std::move(descriptors))});
}
EdgeAssociation::~EdgeAssociation() = default;
EdgeAssociation::EdgeAssociation(EdgeAssociation&&) noexcept = default;

Pairs EdgeAssociation::associate(const EdgeVoxels& b, const Eigen::Isometry3d& T_a_b,
                                 const DescriptorWeights& weights, double gate,
                                 const Pairs* among) {
  const Eigen::Isometry3f T = T_a_b.cast<float>();
  const auto gate2 = static_cast<float>(gate * gate);
  const auto w_o = static_cast<float>(weights.omega_o);
  const auto w_tau = static_cast<float>(weights.omega_tau);
  impl_->tree.setWeights({1, 1, 1, w_o, w_tau, w_tau, w_tau});
  return associateEach(b.size(), among, [&](uint32_t i) {
    const Eigen::Vector3f p = T * b.centre[i];
    const Eigen::Vector3f tau = T.linear() * b.covariance[i].direction().cast<float>();
    auto match = impl_->tree.nearestWithin(
        {p.x(), p.y(), p.z(), b.probability[i], tau.x(), tau.y(), tau.z()}, gate2);
    const auto opposite = impl_->tree.nearestWithin(
        {p.x(), p.y(), p.z(), b.probability[i], -tau.x(), -tau.y(), -tau.z()},
        match ? match->squared_distance : gate2);
    if (opposite) match = opposite;
    if (!match) return Pair{kUnpaired, i, 0};
    const auto& m = impl_->tree.point(match->index);
    return Pair{match->index, i, (Eigen::Vector3f(m[0], m[1], m[2]) - p).squaredNorm()};
  });
}

}  // namespace mrpt::fusion
