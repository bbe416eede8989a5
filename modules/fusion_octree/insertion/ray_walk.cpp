// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Marks the voxels of rays.
 *
 * OctoMap walks along each ray: the next voxel is on the axis whose border is nearest. The nearest
 * axis differs from step to step, so processors guess it wrongly. Here several rays walk together,
 * without branches: comparisons give masks, and the masks choose what is added. The arithmetic of
 * each ray is that of octomap::OcTree::computeRayKeys(), bit for bit.
 *
 * OctoMap ends a ray after each step, either in the voxel of the end or when the length of the ray
 * is reached. Almost all rays reach the voxel of their end in as many steps as the keys of both
 * ends differ. So the rays walk that far without a check. The last step checks the end. Then the
 * voxels are marked. The other rays walk again, with OctoMap's checks. The length needs one check
 * only, because the distances to the borders never decrease.
 *
 * The file is compiled without contraction of products and sums. */

#include "fusion_octree/insertion/ray_walk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace mrpt::fusion {

/** Rays in the order of their numbers of steps. Rays of similar length walk together. */
struct SortedRays {
  template <class T>
  using Column = std::array<T, RayChunk::kMost>;

  size_t size = 0;                  // multiple of the number of rays that walk together
  Column<uint16_t> from;            // index of the ray in its chunk
  Column<float> dx, dy, dz;         // direction
  Column<double> length, steps;     // m; number of steps
  Column<double> to_border[3];      // distance along the ray to the next border, by axis, m
  Column<double> border_gap[3];     // distance along the ray from border to border, by axis, m
  Column<uint64_t> number_step[3];  // what a step adds to the number, by axis
  Column<uint64_t> end;             // number of the voxel of the end
};

namespace {

constexpr double kNever = std::numeric_limits<double>::max();

/** Walks along a ray as octomap::OcTree::computeRayKeys(), with its checks after each step. */
bool walkWithChecks(const octomap::point3d& end_point, const CellKey& end, const RayOrigin& origin,
                    const CellWindow& window, CellMarks& marks) {
  octomap::point3d direction = end_point - origin.point;
  const auto length = static_cast<float>(direction.norm());
  direction /= length;
  std::array<int32_t, 3> step{};
  std::array<double, 3> to_border{}, gap{};
  for (unsigned axis = 0; axis < 3; axis++) {
    const auto d = static_cast<double>(direction(axis));
    step[axis] = d > 0 ? 1 : d < 0 ? -1 : 0;
    to_border[axis] = step[axis] ? origin.to_border[axis][step[axis] > 0] / d : kNever;
    gap[axis] = step[axis] ? origin.resolution / std::fabs(d) : kNever;
  }
  CellKey key = origin.key;
  while (true) {
    if (!window.contains(key)) return false;
    marks.markFree(window.number(key));
    const auto& t = to_border;
    const unsigned axis = t[0] < t[1] ? (t[0] < t[2] ? 0 : 2) : (t[1] < t[2] ? 1 : 2);
    key[axis] += step[axis];
    to_border[axis] += gap[axis];
    if (key == end) return true;
    if (std::min(std::min(t[0], t[1]), t[2]) > static_cast<double>(length)) return true;
  }
}

/** Sorts the rays that have steps by their numbers of steps, and fills up the last group. */
void sortRays(const RayChunk& rays, const CellWindow& window, size_t group, SortedRays& sorted) {
  constexpr size_t kBuckets = 256;
  uint32_t most = 0;
  for (size_t i = 0; i < rays.size; i++) most = std::max(most, rays.steps[i]);
  unsigned shift = 0;
  while (most >> shift >= kBuckets) shift++;
  std::array<uint16_t, kBuckets + 1> first{};
  for (size_t i = 0; i < rays.size; i++) first[(rays.steps[i] >> shift) + 1]++;
  for (size_t b = 1; b <= kBuckets; b++) first[b] = static_cast<uint16_t>(first[b] + first[b - 1]);
  std::array<uint16_t, RayChunk::kMost> order;
  for (size_t i = 0; i < rays.size; i++)
    order[first[rays.steps[i] >> shift]++] = static_cast<uint16_t>(i);

  size_t count = 0;
  const auto add = [&](uint16_t ray) {
    sorted.from[count] = ray;
    sorted.dx[count] = rays.x[ray];
    sorted.dy[count] = rays.y[ray];
    sorted.dz[count] = rays.z[ray];
    sorted.steps[count] = rays.steps[ray];
    sorted.end[count] = window.number(rays.key(ray));
    count++;
  };
  for (size_t i = 0; i < rays.size; i++)
    if (rays.steps[order[i]] > 0) add(order[i]);
  while (count % group != 0) add(sorted.from[count - 1]);
  sorted.size = count;
}

// The functions below are compiled for several kinds of processors.
#define MRPT_FUSION_INLINE __attribute__((always_inline)) inline

/** Computes directions and borders of sorted rays. */
MRPT_FUSION_INLINE void aimRays(const RayOrigin& origin, const CellWindow& window, SortedRays& s) {
  const float ox = origin.point.x(), oy = origin.point.y(), oz = origin.point.z();
  for (size_t i = 0; i < s.size; i++) {
    const float x = s.dx[i] - ox, y = s.dy[i] - oy, z = s.dz[i] - oz;
    const auto length = static_cast<float>(std::sqrt(static_cast<double>(x * x + y * y + z * z)));
    s.length[i] = static_cast<double>(length);
    s.dx[i] = x / length;
    s.dy[i] = y / length;
    s.dz[i] = z / length;
  }
  const float* const directions[3] = {s.dx.data(), s.dy.data(), s.dz.data()};
  for (unsigned axis = 0; axis < 3; axis++) {
    const float* const direction = directions[axis];
    const double down = origin.to_border[axis][0], up = origin.to_border[axis][1];
    const double resolution = origin.resolution;
    const uint64_t one = uint64_t{1} << axis, minus_one = window.mask(axis);
    for (size_t i = 0; i < s.size; i++) {
      const auto d = static_cast<double>(direction[i]);
      const double to_border = (d > 0 ? up : down) / d, gap = resolution / std::fabs(d);
      s.to_border[axis][i] = d != 0 ? to_border : kNever;
      s.border_gap[axis][i] = d != 0 ? gap : kNever;
      s.number_step[axis][i] = d > 0 ? one : minus_one;
    }
  }
}

/** Vectors of kLanes numbers. Each kind of processor has its own size of vectors. */
template <unsigned kLanes>
struct Vectors {
  using Double __attribute__((vector_size(kLanes * 8))) = double;
  using Int __attribute__((vector_size(kLanes * 8))) = int64_t;
  using DoubleInMemory __attribute__((vector_size(kLanes * 8), aligned(8), may_alias)) = double;
  using IntInMemory __attribute__((vector_size(kLanes * 8), aligned(8), may_alias)) = int64_t;
};

/** State of kLanes rays that walk together. */
template <unsigned kLanes>
struct Walk {
  using Double = typename Vectors<kLanes>::Double;
  using Int = typename Vectors<kLanes>::Int;

  MRPT_FUSION_INLINE static Double load(const double* from) {
    return *reinterpret_cast<const typename Vectors<kLanes>::DoubleInMemory*>(from);
  }
  MRPT_FUSION_INLINE static Int load(const uint64_t* from) {
    return *reinterpret_cast<const typename Vectors<kLanes>::IntInMemory*>(from);
  }
  MRPT_FUSION_INLINE static Int all(uint64_t value) { return static_cast<int64_t>(value) - Int{}; }
  MRPT_FUSION_INLINE static Double chosen(Double value, Int mask) {
    return reinterpret_cast<Double>(reinterpret_cast<Int>(value) & mask);
  }

  /** Begins at the origin. */
  MRPT_FUSION_INLINE void begin(const SortedRays& rays, size_t first, const Int& start,
                                const Int* outside) {
    t0 = load(rays.to_border[0].data() + first);
    t1 = load(rays.to_border[1].data() + first);
    t2 = load(rays.to_border[2].data() + first);
    n0 = start | outside[0];
    n1 = start | outside[1];
    n2 = start | outside[2];
    wrong = Int{};
  }
  /** Chooses the axis of the next step: that of the nearest border. If borders are equally near,
   * the order of the comparisons decides, as in computeRayKeys(). */
  MRPT_FUSION_INLINE void choose() {
    nearest01 = t0 < t1 ? t0 : t1;
    const Int not2 = nearest01 < t2;
    on2 = t2 <= nearest01;
    on0 = (t0 < t1) & not2;
    on1 = on0 ^ not2;
  }
  /** Steps, on the chosen axis. Of each axis, the bits of the other axes are kept set, so that a
   * carry passes through them. */
  MRPT_FUSION_INLINE void step(const SortedRays& rays, size_t first, const Int* outside) {
    t0 += chosen(load(rays.border_gap[0].data() + first), on0);
    t1 += chosen(load(rays.border_gap[1].data() + first), on1);
    t2 += chosen(load(rays.border_gap[2].data() + first), on2);
    n0 = (n0 + (load(rays.number_step[0].data() + first) & on0)) | outside[0];
    n1 = (n1 + (load(rays.number_step[1].data() + first) & on1)) | outside[1];
    n2 = (n2 + (load(rays.number_step[2].data() + first) & on2)) | outside[2];
  }
  /** As choose() and step(), but only for rays with more than \a count steps. Checks the rays whose
   * last step this is: it must lead to the end, and within the length of the ray. */
  MRPT_FUSION_INLINE void stepOrEnd(const SortedRays& rays, size_t first, double count,
                                    const Int* outside) {
    choose();
    const Double steps = load(rays.steps.data() + first), now = count - Double{};
    const Int goes_on = now < steps, ends = now == steps;
    const Double nearest = on2 ? t2 : nearest01;
    Walk next = *this;
    next.step(rays, first, outside);
    wrong |= ends & ((next.number() != load(rays.end.data() + first)) |
                     (nearest > load(rays.length.data() + first)));
    on0 &= goes_on;
    on1 &= goes_on;
    on2 &= goes_on;
    step(rays, first, outside);
  }
  /** Returns the numbers of the voxels of the rays. */
  MRPT_FUSION_INLINE Int number() const { return n0 & n1 & n2; }
  MRPT_FUSION_INLINE void store(uint64_t* to) const {
    *reinterpret_cast<typename Vectors<kLanes>::IntInMemory*>(to) = number();
  }

  Double t0, t1, t2;  // distances to the next borders along the rays, m
  Int n0, n1, n2;     // numbers of the voxels: bits of an axis, with all other bits set
  Double nearest01;   // the nearer of t0 and t1
  Int on0, on1, on2;  // masks: the step is on this axis
  Int wrong;          // masks: the last step did not lead to the end
};

/** Walks along kGroups * kLanes sorted rays. Several groups keep the processor busy while it waits
 * for sums. \param[out] cells Numbers of the voxels: for each step, the voxels of all rays. A ray
 * that has ended stays in its last voxel. \param[out] wrong Whether a ray must walk again. */
template <unsigned kLanes, unsigned kGroups>
MRPT_FUSION_INLINE void walkTogether(const SortedRays& rays, size_t first, size_t least,
                                     size_t most, uint64_t start, const CellWindow& window,
                                     uint64_t* __restrict cells, bool* wrong) {
  using Lanes = Walk<kLanes>;
  const typename Lanes::Int outside[3] = {Lanes::all(~window.mask(0)), Lanes::all(~window.mask(1)),
                                          Lanes::all(~window.mask(2))};
  Lanes walk[kGroups];
  for (unsigned g = 0; g < kGroups; g++) {
    walk[g].begin(rays, first + g * kLanes, Lanes::all(start), outside);
    walk[g].store(cells + g * kLanes);
  }
  uint64_t* __restrict to = cells + kGroups * kLanes;
  size_t count = 1;
  for (; count < least; count++, to += kGroups * kLanes) {
#pragma GCC unroll 4
    for (unsigned g = 0; g < kGroups; g++) {
      walk[g].choose();
      walk[g].step(rays, first + g * kLanes, outside);
      walk[g].store(to + g * kLanes);
    }
  }
  for (; count <= most; count++, to += kGroups * kLanes) {
#pragma GCC unroll 4
    for (unsigned g = 0; g < kGroups; g++) {
      walk[g].stepOrEnd(rays, first + g * kLanes, static_cast<double>(count), outside);
      walk[g].store(to + g * kLanes);
    }
  }
  for (unsigned g = 0; g < kGroups; g++)
    for (unsigned l = 0; l < kLanes; l++) wrong[g * kLanes + l] = walk[g].wrong[l] != 0;
}

/** Marks kRays * rows voxels. Near the origin all rays are in the same voxels. A processor waits if
 * it writes to the same place again and again. So each ray begins at another distance. */
template <unsigned kRays>
MRPT_FUSION_INLINE void markAll(const uint64_t* cells, size_t rows, CellMarks& marks) {
  const size_t part = rows / kRays * kRays;
  for (size_t turn = 0; turn < kRays; turn++) {
    const uint64_t* from[kRays];
    for (unsigned l = 0; l < kRays; l++) from[l] = cells + (turn + l) % kRays * part + l;
    for (size_t k = 0; k < part; k += kRays)
      for (unsigned l = 0; l < kRays; l++) marks.markFree(from[l][k]);
  }
  for (size_t i = part * kRays; i < rows * kRays; i++) marks.markFree(cells[i]);
}

/** RayWalker::walk() for vectors of kLanes. */
template <unsigned kLanes, unsigned kGroups>
MRPT_FUSION_INLINE bool walkAll(const RayChunk& rays, const RayOrigin& origin,
                                const CellWindow& window, SortedRays& sorted,
                                std::vector<uint64_t>& cells, CellMarks& marks) {
  constexpr unsigned kRays = kLanes * kGroups;
  static_assert(RayChunk::kMost % kRays == 0);
  aimRays(origin, window, sorted);
  const uint64_t start = window.number(origin.key);
  for (size_t first = 0; first < sorted.size; first += kRays) {
    const auto* const steps = sorted.steps.data() + first;
    const auto least = static_cast<size_t>(*std::min_element(steps, steps + kRays));
    const auto most = static_cast<size_t>(*std::max_element(steps, steps + kRays));
    if (cells.size() < (most + 1) * kRays) cells.resize(2 * (most + 1) * kRays);
    bool wrong[kRays];
    walkTogether<kLanes, kGroups>(sorted, first, least, most, start, window, cells.data(), wrong);
    if (std::none_of(wrong, wrong + kRays, [](bool w) { return w; })) {
      markAll<kRays>(cells.data(), most, marks);
      continue;
    }
    for (unsigned l = 0; l < kRays; l++) {
      const uint16_t i = sorted.from[first + l];
      if (!wrong[l])
        for (size_t k = 0; k < most; k++) marks.markFree(cells[k * kRays + l]);
      else if (!walkWithChecks({rays.x[i], rays.y[i], rays.z[i]}, rays.key(i), origin, window,
                               marks))
        return false;
    }
  }
  return true;
}

#if defined(__x86_64__)
__attribute__((target("avx2,bmi2"))) bool walkEight(const RayChunk& rays, const RayOrigin& origin,
                                                    const CellWindow& window, SortedRays& sorted,
                                                    std::vector<uint64_t>& cells,
                                                    CellMarks& marks) {
  return walkAll<4, 2>(rays, origin, window, sorted, cells, marks);
}
bool canWalkEight() { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2"); }
#else
bool walkEight(const RayChunk& rays, const RayOrigin& origin, const CellWindow& window,
               SortedRays& sorted, std::vector<uint64_t>& cells, CellMarks& marks) {
  return walkAll<2, 4>(rays, origin, window, sorted, cells, marks);
}
bool canWalkEight() { return true; }
#endif

}  // namespace

RayWalker::RayWalker(Lanes lanes)
    : eight_(lanes == Lanes::Best && canWalkEight()), sorted_(std::make_unique<SortedRays>()) {}
RayWalker::RayWalker(RayWalker&&) noexcept = default;
RayWalker& RayWalker::operator=(RayWalker&&) noexcept = default;
RayWalker::~RayWalker() = default;

bool RayWalker::walk(const RayChunk& rays, const RayOrigin& origin, const CellWindow& window,
                     CellMarks& marks) {
  for (size_t i = 0; i < rays.size; i++)
    if (rays.hit[i]) marks.markOccupied(window.number(rays.key(i)));
  constexpr size_t kMostTogether = 8;
  sortRays(rays, window, kMostTogether, *sorted_);
  return eight_ ? walkEight(rays, origin, window, *sorted_, cells_, marks)
                : walkAll<2, 4>(rays, origin, window, *sorted_, cells_, marks);
}

}  // namespace mrpt::fusion
