// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/edges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "fusion_base/parallel.h"
#include "fusion_core/features/least_axis.h"
#include "fusion_core/map/kd_tree.h"
#include "fusion_core/map/voxel_blocks.h"

namespace mrpt::fusion {
namespace {

/** The longest radius, in voxels. A map in which more are within one is of smaller things than
 * buildings, and what is around a voxel takes memory and time by the cube of its radius. */
constexpr double kMostVoxels = 64;

double radiusInVoxels(double radius, double least, double resolution) {
  return resolution > 0 ? std::clamp(radius / resolution, least, kMostVoxels) : least;
}

VoxelBlocks::Ball normalBall(const EdgeParams& params, double resolution) {
  constexpr double kMostExact = 20;  // see Moments
  return VoxelBlocks::Ball(
      std::min(radiusInVoxels(params.normal_radius, params.min_normal_radius_voxels, resolution),
               kMostExact));
}

VoxelBlocks::Ball costBall(const EdgeParams& params, double resolution) {
  return VoxelBlocks::Ball(
      radiusInVoxels(params.cost_radius, params.min_cost_radius_voxels, resolution));
}

constexpr uint32_t kNone = ~uint32_t{0};

VoxelBlocks::Place placeOf(const octomap::OcTreeKey& key) { return {key[0], key[1], key[2]}; }

/** Four numbers in one register. */
using Four = float __attribute__((vector_size(16)));

/** Sums over some cells of a block of 4x4x4, by their coordinates (0 to 3) in it. */
struct CellSums {
  Four xyz = {};       ///< and how many
  Four squares = {};   ///< xx, yy, zz
  Four products = {};  ///< xy, xz, yz

  static constexpr CellSums ofCell(int cell) {
    const auto at = VoxelBlocks::coordinatesOf(cell);
    const auto x = static_cast<float>(at[0]), y = static_cast<float>(at[1]),
               z = static_cast<float>(at[2]);
    return {Four{x, y, z, 1}, Four{x * x, y * y, z * z, 0}, Four{x * y, x * z, y * z, 0}};
  }
  constexpr void operator+=(const CellSums& o) {
    xyz += o.xyz;
    squares += o.squares;
    products += o.products;
  }
};

/** Of all sets of eight cells that follow each other in a block: a block's sums are added up
 * without a branch. */
constexpr auto kSumsOfEight = [] {
  std::array<std::array<CellSums, 256>, 8> sums{};
  for (unsigned eight = 0; eight < 8; eight++)
    for (unsigned cells = 1; cells < 256; cells++) {
      const unsigned first = static_cast<unsigned>(__builtin_ctz(cells));
      sums[eight][cells] = sums[eight][cells & (cells - 1)];
      sums[eight][cells] += CellSums::ofCell(static_cast<int>(8 * eight + first));
    }
  return sums;
}();

/** Mean and spread of a set of offsets. Sums of whole numbers: exact, whatever their order, up to
 * 2^24, which those of a ball of 20 voxels do not reach. */
class Moments {
 public:
  /** Adds the offsets of a block's voxels.
   * \param[in] cells Those that are there. \param[in] offset Of its lowest cell. */
  void add(uint64_t cells, const VoxelBlocks::Offset& offset) {
    CellSums in_block;
    for (size_t eight = 0; eight < 8; eight++)
      in_block += kSumsOfEight[eight][cells >> (8 * eight) & 255U];
    const Four o = {static_cast<float>(offset[0]), static_cast<float>(offset[1]),
                    static_cast<float>(offset[2]), 0};
    const Four from_block = in_block.xyz;
    const Four from_origin = from_block + from_block[3] * o;
    sums_.xyz += from_origin;
    sums_.squares += in_block.squares + (from_block + from_origin) * o;
    const auto first = [](const Four& v) { return __builtin_shufflevector(v, v, 0, 0, 1, 3); };
    const auto second = [](const Four& v) { return __builtin_shufflevector(v, v, 1, 2, 2, 3); };
    sums_.products +=
        in_block.products + first(from_block) * second(o) + second(from_origin) * first(o);
  }
  size_t size() const { return static_cast<size_t>(sums_.xyz[3]); }
  Eigen::Vector3d mean() const { return toVector(sums_.xyz) / static_cast<double>(sums_.xyz[3]); }
  Eigen::Matrix3d covariance() const {
    const Eigen::Vector3d square = toVector(sums_.squares), product = toVector(sums_.products);
    Eigen::Matrix3d squares;
    squares << square.x(), product.x(), product.y(), product.x(), square.y(), product.z(),
        product.y(), product.z(), square.z();
    const Eigen::Vector3d m = mean();
    return squares / static_cast<double>(sums_.xyz[3]) - m * m.transpose();
  }

 private:
  static Eigen::Vector3d toVector(const Four& v) { return {v[0], v[1], v[2]}; }
  CellSums sums_;
};

/** lambda_3 / (lambda_1 + lambda_2 + lambda_3), lambda_3 the least, if there is a plane. */
std::optional<double> surfaceVariation(const LeastAxis& across, const EdgeParams& params) {
  const double variation = across.value() / across.trace();
  if (!across.othersExceed(1e-6) || variation > params.max_surface_variation) return std::nullopt;
  return variation;
}

Moments momentsAround(const VoxelBlocks& blocks, const VoxelBlocks::Ball& ball,
                      const octomap::OcTreeKey& key) {
  Moments moments;
  blocks.forEachBlockAround(placeOf(key), ball,
                            [&](uint64_t cells, const VoxelBlocks::Offset& lowest) {
                              moments.add(cells, lowest);
                              return false;
                            });
  return moments;
}

/** The plane through the voxels around one. */
struct Plane {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit vector, or zero: there is none
  float variation = 0;
  float height = 0;  // above the voxel along the normal, voxels
};
Plane surfaceAround(const VoxelBlocks& occupied, const VoxelBlocks::Ball& ball,
                    const octomap::OcTreeKey& key, const EdgeParams& params) {
  const Moments moments = momentsAround(occupied, ball, key);
  const LeastAxis across(moments.covariance());
  const auto variation = surfaceVariation(across, params);
  if (!variation) return {};
  const Eigen::Vector3d normal = across.direction();
  return {normal.cast<float>(), static_cast<float>(*variation),
          static_cast<float>(normal.dot(moments.mean()))};
}

/** Eq. (5) for one voxel that has a normal: \a near are those around it, itself included. */
float angleCost(const VoxelBlocks& near, const VoxelBlocks::Ball& ball,
                const octomap::OcTreeKey& key, const Eigen::Vector3f& normal,
                const std::vector<Eigen::Vector3f>& normals) {
  float sum = 0;
  int n = 0;
  near.forEachAround(placeOf(key), ball, [&](uint32_t j, const VoxelBlocks::Offset&) {
    const Eigen::Vector3f& other = normals[j];
    if (other.isZero(0)) return;
    sum += other.cross(normal).norm();
    n++;
  });
  return sum / static_cast<float>(n);
}

/** The direction in a voxel's tangent plane in which the normals around it vary most: across the
 * edge, if it lies on one. Unit vector. */
Eigen::Vector3f acrossEdge(const VoxelBlocks& near, const VoxelBlocks::Ball& ball,
                           const octomap::OcTreeKey& key, const Eigen::Vector3f& normal,
                           const std::vector<Eigen::Vector3f>& normals) {
  const Eigen::Vector3f u = normal.unitOrthogonal(), v = normal.cross(u);
  float uu = 0, uv = 0, vv = 0;
  near.forEachAround(placeOf(key), ball, [&](uint32_t j, const VoxelBlocks::Offset&) {
    const float a = normals[j].dot(u), b = normals[j].dot(v);
    uu += a * a;
    uv += a * b;
    vv += b * b;
  });
  // The larger principal axis of the 2x2 scatter, at half the angle of (uu - vv, 2 uv).
  const float x = uu - vv, y = 2 * uv, length = std::hypot(x, y);
  if (length == 0) return u;
  return x >= 0 ? ((length + x) * u + y * v).normalized()
                : (std::abs(y) * u + std::copysign(length - x, y) * v).normalized();
}

/** Walks along the surface around one voxel (Algorithm 1, lines 9-16).
 *
 * A walk stays near the slice that the voxel's normal and the walk's first direction span: there
 * the surface is a curve, and following it is a walk from voxel to voxel that may turn a right
 * angle (from a wall onto the floor) but not back. Lengths in voxels, in the slice's coordinates:
 * along the first direction, and above the voxel along its normal. */
class SurfaceTracer {
 public:
  SurfaceTracer(const VoxelBlocks& occupied, double distance)
      : occupied_(occupied, static_cast<int>(std::ceil(distance + 2 * kMaxStep))),
        distance_(static_cast<float>(distance)) {}

  void moveTo(const octomap::OcTreeKey& voxel) { occupied_.moveTo(placeOf(voxel)); }

  /** The angle between the vectors to the ends of the walks that leave the voxel along \a tangent
   * and against it, rad; none if the surface ends before d_T on a side. */
  std::optional<float> bend(const Eigen::Vector3f& tangent, const Eigen::Vector3f& normal) {
    tangent_ = tangent;
    normal_ = normal;
    lateral_ = normal.cross(tangent);
    const auto t1 = trace({1, 0});
    if (!t1) return std::nullopt;
    const auto t2 = trace({-1, 0});
    if (!t2) return std::nullopt;
    return std::acos(std::clamp(t1->dot(*t2), -1.F, 1.F));
  }

 private:
  using Offset = VoxelBlocks::Offset;
  static constexpr float kMaxStep = 2.3F;      ///< across gaps of a sparsely seen surface
  static constexpr float kMinStep = 0.5F;      ///< within the slice
  static constexpr float kMinForward = -0.1F;  ///< cosine of the sharpest turn in one step
  static constexpr float kHalfSlice = 0.75F;   ///< slices this thick miss no voxel of a surface
  static constexpr float kUnreachable = 1e9F;

  struct Spot {
    Offset offset;          ///< from the voxel that the walk started from
    Eigen::Vector2f place;  ///< the same in the slice
  };

  /** TraceVectorAlongSurfaceVoxels: unit vector to where the walk is d_T away. */
  std::optional<Eigen::Vector2f> trace(Eigen::Vector2f direction) {
    Spot at{{0, 0, 0}, {0, 0}};
    const int max_steps = 3 * static_cast<int>(distance_);
    for (int step = 0; step < max_steps; step++) {
      if (at.place.squaredNorm() >= (distance_ - 0.5F) * (distance_ - 0.5F))
        return middleOfSurfaceAt(at).normalized();
      const Eigen::Vector2f before = at.place;
      if (!stepAhead(at, direction) && !stepAcross(at, direction)) return std::nullopt;
      direction = (direction + 2 * (at.place - before)).normalized();
    }
    return std::nullopt;  // going round in a clutter of voxels
  }

  /** To the voxel nearest to one step ahead, if one of the eight around that place is there. */
  bool stepAhead(Spot& at, const Eigen::Vector2f& direction) {
    const Eigen::Vector2f ahead = at.place + direction;
    const Eigen::Vector3f target = ahead.x() * tangent_ + ahead.y() * normal_;
    Offset low;
    float squared[3][2];  // from the target to the lower and the upper voxels, along each axis
    unsigned nearest = 0;
    for (unsigned axis = 0; axis < 3; axis++) {
      low[axis] = floorOf(target[axis]);
      const float above = target[axis] - static_cast<float>(low[axis]);
      squared[axis][0] = above * above;
      squared[axis][1] = (1 - above) * (1 - above);
      nearest |= (above > 0.5F ? 1U : 0U) << axis;
    }
    float least = kUnreachable;
    Offset best{};
    for (unsigned flips = 0; flips < 8; flips++) {  // the nearest first: mostly it is there
      const unsigned corner = nearest ^ flips;
      const unsigned x = corner & 1U, y = corner >> 1U & 1U, z = corner >> 2U;
      const float distance = squared[0][x] + squared[1][y] + squared[2][z];
      const Offset next{low[0] + static_cast<int>(x), low[1] + static_cast<int>(y),
                        low[2] + static_cast<int>(z)};
      if (distance >= least || !occupied_.has(next) || next == at.offset ||
          std::abs(toVector(next).dot(lateral_)) > kHalfSlice)
        continue;
      least = distance;
      best = next;
      if (flips == 0) break;
    }
    if (least == kUnreachable) return false;
    at = {best, inSlice(toVector(best))};
    return true;
  }

  /** Beside the way, round a corner or across a gap: to the voxel in the slice nearest to one step
   * ahead, among all that a step reaches. */
  bool stepAcross(Spot& at, const Eigen::Vector2f& direction) {
    float least = kUnreachable;
    Spot best = at;
    occupied_.forEachAround(at.offset, stepBall(), [&](const Offset& next) {
      const Eigen::Vector3f offset = toVector(next);
      if (std::abs(offset.dot(lateral_)) > kHalfSlice) return;
      const Eigen::Vector2f place = inSlice(offset), way = place - at.place;
      const float forward = way.dot(direction), squared_length = way.squaredNorm();
      if (squared_length < kMinStep * kMinStep ||
          (forward < 0 && forward * forward > kMinForward * kMinForward * squared_length))
        return;
      constexpr float kNearFirst = 1e-3F;  // of two as good, whatever their order
      const float distance = (way - direction).squaredNorm() + kNearFirst * squared_length;
      if (distance >= least) return;
      least = distance;
      best = {next, place};
    });
    at = best;
    return least < kUnreachable;
  }

  /** The mean of the slice's voxels about a place: a single one tells the surface to half a voxel
   * only, which is 6 degrees of a walk of five. */
  Eigen::Vector2f middleOfSurfaceAt(const Spot& at) {
    constexpr float kRadius2 = 1.6F * 1.6F;
    static const VoxelBlocks::Ball ball(std::hypot(1.6, 2 * kHalfSlice));
    Eigen::Vector2f sum = Eigen::Vector2f::Zero();
    int n = 0;
    occupied_.forEachAround(at.offset, ball, [&](const Offset& near) {
      const Eigen::Vector3f offset = toVector(near);
      const Eigen::Vector2f place = inSlice(offset);
      const bool itself = near == at.offset;
      if (!itself && (std::abs(offset.dot(lateral_)) > kHalfSlice ||
                      (place - at.place).squaredNorm() > kRadius2))
        return;
      sum += place;
      n++;
    });
    return sum / static_cast<float>(n);
  }

  static Eigen::Vector3f toVector(const Offset& o) {
    return {static_cast<float>(o[0]), static_cast<float>(o[1]), static_cast<float>(o[2])};
  }
  static const VoxelBlocks::Ball& stepBall() {
    static const VoxelBlocks::Ball ball(kMaxStep);
    return ball;
  }
  static int floorOf(float x) {
    const int i = static_cast<int>(x);
    return i - (x < static_cast<float>(i) ? 1 : 0);
  }
  Eigen::Vector2f inSlice(const Eigen::Vector3f& v) const {
    return {v.dot(tangent_), v.dot(normal_)};
  }

  VoxelBlocks::Window occupied_;
  float distance_;
  Eigen::Vector3f tangent_, normal_, lateral_;
};

/** The directions of the walks, each with its opposite, in the tangent plane: x across the edge. */
std::vector<Eigen::Vector2f> walkDirections(const EdgeParams& params) {
  std::vector<Eigen::Vector2f> directions;
  const auto add = [&](double angle) {
    directions.emplace_back(static_cast<float>(std::cos(angle)),
                            static_cast<float>(std::sin(angle)));
  };
  add(0);
  constexpr double kRightAngle = M_PI / 2, kRounding = 1e-9;
  double angle = params.trace_step_angle;
  for (; angle <= params.trace_window + kRounding && angle < kRightAngle - kRounding;
       angle += params.trace_step_angle) {
    add(angle);
    add(-angle);
  }
  add(kRightAngle);
  return directions;
}

/** Lines 10-20: whether the surface bends by an angle in the window at the tracer's voxel. */
bool isBend(SurfaceTracer& tracer, const std::vector<Eigen::Vector2f>& directions,
            const Eigen::Vector3f& normal, const Eigen::Vector3f& across,
            const EdgeParams& params) {
  const Eigen::Vector3f along = normal.cross(across);
  const auto bend = [&](const Eigen::Vector2f& d) {
    return tracer.bend(d.x() * across + d.y() * along, normal);
  };
  const auto isEdge = [&](const std::optional<float>& angle) {
    return angle && *angle > params.alpha_min && *angle < params.alpha_max;
  };
  const auto first = bend(directions.front());
  if (isEdge(first)) return true;
  // What is far from a bend straight across is none a little to the side either, but by chance.
  constexpr double kNearly = 20 * M_PI / 180;  // beyond the window
  const bool anywhere = params.trace_window >= M_PI / 2;
  if (!anywhere &&
      !(first && *first > params.alpha_min - kNearly && *first < params.alpha_max + kNearly))
    return false;
  return std::any_of(directions.begin() + 1, directions.end(),
                     [&](const Eigen::Vector2f& d) { return isEdge(bend(d)); });
}

/** Lines 7-22: of the voxels that each candidate stands for the one that is an edge, or kNone. */
std::vector<uint32_t> detectEdges(const OccupiedVoxels& voxels, const VoxelBlocks& occupied,
                                  const SurfaceVoxels& pieces,
                                  const std::vector<uint32_t>& candidates,
                                  const EdgeParams& params) {
  const Surfaces& surfaces = pieces.surfaces;
  const VoxelBlocks near(pieces.voxels.key);
  const VoxelBlocks::Ball cost_ball = costBall(params, voxels.resolution);
  const VoxelBlocks::Ball bend_ball = normalBall(params, voxels.resolution);
  const double distance = radiusInVoxels(params.trace_distance, 4, voxels.resolution);
  const auto directions = walkDirections(params);
  std::vector<uint32_t> first_of(pieces.voxels.size() + 1, 0);  // of the voxels of each
  for (size_t k = 0; k < pieces.voxels.size(); k++)
    first_of[k + 1] = first_of[k] + static_cast<uint32_t>(surfaces.weight[k]);

  // Where the surface bends most, and its normal there: the piece's own voxel may lie beside the
  // edge.
  const auto mostBent = [&](size_t k) {
    const uint32_t first = first_of[k], end = first_of[k + 1];
    std::pair best(first, surfaces.normal[k]);
    if (end == first + 1) return best;
    float most = -1;
    for (uint32_t i = first; i < end; i++) {
      const octomap::OcTreeKey& key = voxels.key[i];
      Plane here{surfaces.normal[k], surfaces.variation[k]};
      if (key != pieces.voxels.key[k]) here = surfaceAround(occupied, bend_ball, key, params);
      if (here.variation <= most) continue;
      most = here.variation;
      best = {i, here.normal};
    }
    return best;
  };

  std::vector<uint32_t> found(candidates.size(), kNone);
  forEachRange(found.size(), kGrain, [&](size_t begin, size_t end) {
    SurfaceTracer tracer(occupied, distance);
    for (size_t c = begin; c < end; c++) {
      const size_t k = candidates[c];
      if (surfaces.variation[k] < params.min_surface_variation) continue;
      const auto [i, normal] = mostBent(k);
      const octomap::OcTreeKey& key = voxels.key[i];
      if (normal.isZero(0) ||
          angleCost(near, cost_ball, key, normal, surfaces.normal) <= params.kappa)
        continue;
      tracer.moveTo(key);
      const Eigen::Vector3f u = acrossEdge(near, bend_ball, key, normal, surfaces.normal);
      if (isBend(tracer, directions, normal, u, params)) found[c] = i;
    }
  });
  return found;
}

/** Line 23: indices of the points whose mean distance to their nearest neighbours is not larger
 * than the mean of all plus so many standard deviations. */
std::vector<uint32_t> statisticalInliers(const std::vector<Eigen::Vector3f>& points,
                                         const EdgeParams& params) {
  std::vector<uint32_t> kept;
  const size_t k =
      std::min<size_t>(params.outlier_neighbours, points.empty() ? 0 : points.size() - 1);
  if (k == 0) return kept;
  const KdTree<3> tree(toDescriptors(points));
  std::vector<double> mean_distance(points.size());
  forEachIndex(points.size(), kGrain, [&](size_t i) {
    const auto neighbours = tree.nearest(tree.point(i), k + 1);  // the point itself is one
    double sum = 0;
    for (const float squared : neighbours.squared_distance) sum += std::sqrt(squared);
    mean_distance[i] = sum / static_cast<double>(k);
  });
  double mean = 0, squares = 0;
  for (const double d : mean_distance) {
    mean += d;
    squares += d * d;
  }
  const auto n = static_cast<double>(points.size());
  mean /= n;
  const double deviation = std::sqrt(std::max(0.0, squares / n - mean * mean));
  for (uint32_t i = 0; i < points.size(); i++)
    if (mean_distance[i] <= mean + params.outlier_deviations * deviation) kept.push_back(i);
  return kept;
}

/** Eq. (6) for each edge voxel, from the edge voxels around it. */
std::vector<EdgeCovariance> edgeCovariances(const std::vector<octomap::OcTreeKey>& edges,
                                            double radius, double resolution) {
  const VoxelBlocks blocks(edges);
  // Just beyond the radius: whether a voxel at that very distance counts must not hang on rounding.
  const VoxelBlocks::Ball ball(radius / resolution + 1e-3);
  std::vector<EdgeCovariance> covariances(edges.size());
  forEachIndex(edges.size(), kGrain, [&](size_t i) {
    const Moments moments = momentsAround(blocks, ball, edges[i]);
    covariances[i] = edgeCovariance(resolution * resolution * moments.covariance(), moments.size());
  });
  return covariances;
}

}  // namespace

Surfaces computeSurfaces(const OccupiedVoxels& voxels, const VoxelBlocks& occupied,
                         const EdgeParams& params) {
  const VoxelBlocks::Ball ball = normalBall(params, voxels.resolution);
  Surfaces surfaces;
  surfaces.normal.assign(voxels.size(), Eigen::Vector3f::Zero());
  surfaces.variation.assign(voxels.size(), 0);
  surfaces.weight.assign(voxels.size(), 1);
  surfaces.point = voxels.centre;
  forEachIndex(voxels.size(), kGrain, [&](size_t i) {
    const Plane plane = surfaceAround(occupied, ball, voxels.key[i], params);
    const auto height = static_cast<float>(voxels.resolution) * plane.height;
    surfaces.normal[i] = plane.normal;
    surfaces.point[i] += height * plane.normal;
    surfaces.variation[i] = plane.variation;
  });
  return surfaces;
}

Surfaces computeSurfaces(const OccupiedVoxels& voxels, const EdgeParams& params) {
  return computeSurfaces(voxels, VoxelBlocks(voxels.key), params);
}

std::vector<float> computeAngleCosts(const OccupiedVoxels& voxels,
                                     const std::vector<Eigen::Vector3f>& normals,
                                     const EdgeParams& params) {
  const VoxelBlocks blocks(voxels.key);
  const VoxelBlocks::Ball ball = costBall(params, voxels.resolution);
  std::vector<float> costs(voxels.size());
  forEachIndex(voxels.size(), kGrain, [&](size_t i) {
    if (!normals[i].isZero(0))
      costs[i] = angleCost(blocks, ball, voxels.key[i], normals[i], normals);
  });
  return costs;
}

EdgeVoxels extractEdges(const OccupiedVoxels& voxels, const EdgeParams& params) {
  const VoxelBlocks occupied(voxels.key);
  std::vector<uint32_t> all(voxels.size());
  std::iota(all.begin(), all.end(), 0);
  return extractEdges(voxels, occupied, {voxels, computeSurfaces(voxels, occupied, params)}, all,
                      params);
}

EdgeVoxels extractEdges(const OccupiedVoxels& voxels, const VoxelBlocks& occupied,
                        const SurfaceVoxels& pieces, const std::vector<uint32_t>& candidates,
                        const EdgeParams& params) {
  std::vector<uint32_t> found = detectEdges(voxels, occupied, pieces, candidates, params);
  found.erase(std::remove(found.begin(), found.end(), kNone), found.end());
  std::vector<Eigen::Vector3f> points;
  for (const uint32_t i : found) points.push_back(voxels.centre[i]);

  std::vector<octomap::OcTreeKey> keys;
  std::vector<float> probability;
  for (const uint32_t i : statisticalInliers(points, params)) {
    keys.push_back(voxels.key[found[i]]);
    probability.push_back(voxels.probability[found[i]]);
  }
  return edgeVoxelsAt(keys, std::move(probability), octomap::OcTree(voxels.resolution),
                      params.direction_radius);
}

EdgeVoxels edgeVoxelsAt(const std::vector<octomap::OcTreeKey>& at, std::vector<float> probability,
                        const octomap::OcTree& grid, double direction_radius) {
  EdgeVoxels edges;
  edges.resolution = grid.getResolution();
  edges.direction_radius =
      std::clamp(direction_radius, 3 * edges.resolution, kMostVoxels * edges.resolution);
  edges.probability = std::move(probability);
  edges.centre.reserve(at.size());
  for (const auto& key : at) {
    const octomap::point3d p = grid.keyToCoord(key);
    edges.centre.emplace_back(p.x(), p.y(), p.z());
  }
  edges.covariance = edgeCovariances(at, edges.direction_radius, edges.resolution);
  return edges;
}

}  // namespace mrpt::fusion
