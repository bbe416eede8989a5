// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/math/KDTreeCapable.h>  // includes nanoflann

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

/** \file
 * A kd-tree over descriptors with weighted axes. */

namespace mrpt::fusion {

/** A nanoflann kd-tree over descriptors. The weights of the axes can change between queries: the
 * squared distance is sum_d weight[d] (a[d] - b[d])^2. The splits do not depend on the weights, so
 * all iterations use the same tree. Cost: O(n log n) to build, about O(log n) for a query. */
template <int Dim>
class KdTree {
 public:
  using Descriptor = std::array<float, Dim>;

  explicit KdTree(std::vector<Descriptor> points)
      : data_{std::move(points), ones()},
        tree_(Dim, data_, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {}
  KdTree(const KdTree&) = delete;
  KdTree& operator=(const KdTree&) = delete;

  const Descriptor& point(size_t i) const { return data_.points[i]; }

  /** Sets the weights of the axes. Must not be called during a query. */
  void setWeights(const Descriptor& weights) { data_.weights = weights; }

  struct Nearest {
    uint32_t index;
    float squared_distance;
  };
  /** Returns the nearest point within the gate (squared, weighted), or nothing. */
  std::optional<Nearest> nearestWithin(const Descriptor& query, float squared_gate) const {
    GatedResult result(squared_gate);
    tree_.findNeighbors(result, query.data(), nanoflann::SearchParams());
    if (result.index == kNone) return std::nullopt;
    return Nearest{result.index, result.best};
  }

  struct NearestK {
    std::vector<uint32_t> index;
    std::vector<float> squared_distance;
  };
  NearestK nearest(const Descriptor& query, size_t k) const {
    NearestK r{std::vector<uint32_t>(k), std::vector<float>(k)};
    const size_t n = tree_.knnSearch(query.data(), k, r.index.data(), r.squared_distance.data());
    r.index.resize(n);
    r.squared_distance.resize(n);
    return r;
  }

 private:
  static constexpr uint32_t kNone = ~uint32_t{0};

  static Descriptor ones() {
    Descriptor d;
    d.fill(1);
    return d;
  }

  struct Data {
    std::vector<Descriptor> points;
    Descriptor weights;

    size_t kdtree_get_point_count() const { return points.size(); }
    float kdtree_get_pt(size_t i, size_t d) const { return points[i][d]; }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
      return false;
    }
  };

  struct Metric {
    using ElementType = float;
    using DistanceType = float;
    const Data& data;

    explicit Metric(const Data& d) : data(d) {}
    float evalMetric(const float* a, uint32_t b, size_t) const {
      float sum = 0;
      for (size_t d = 0; d < Dim; d++) sum += accum_dist(a[d], data.points[b][d], d);
      return sum;
    }
    float accum_dist(float a, float b, size_t d) const {
      return data.weights[d] * (a - b) * (a - b);
    }
  };

  /** nanoflann result set of the nearest point within the gate. Of points at equal distance it
   * keeps the lower index, so the result does not depend on the layout of the tree. */
  struct GatedResult {
    explicit GatedResult(float gate) : best(gate), worst(justAbove(gate)) {}

    float best, worst;
    uint32_t index = kNone;

    size_t size() const { return index == kNone ? 0 : 1; }
    bool full() const { return true; }
    /** Returns a distance just above the best: nanoflann skips points at this exact distance, and
     * points at equal distance must be compared. */
    float worstDist() const { return worst; }
    static float justAbove(float x) { return std::nextafter(x, std::numeric_limits<float>::max()); }
    bool addPoint(float distance, uint32_t i) {
      if (distance < best || (distance == best && index != kNone && i < index)) {
        best = distance;
        worst = justAbove(distance);
        index = i;
      }
      return true;
    }
  };

  Data data_;
  nanoflann::KDTreeSingleIndexAdaptor<Metric, Data, Dim, uint32_t> tree_;
};

inline std::vector<std::array<float, 3>> toDescriptors(const std::vector<Eigen::Vector3f>& points) {
  std::vector<std::array<float, 3>> d;
  d.reserve(points.size());
  for (const auto& p : points) d.push_back({p.x(), p.y(), p.z()});
  return d;
}

}  // namespace mrpt::fusion
