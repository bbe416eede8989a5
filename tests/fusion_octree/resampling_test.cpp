// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_octree/resampling.h"

#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <limits>

#include "support/reference_resampling.h"
#include "support/tree_tools.h"

using namespace map_tests;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using mrpt::fusion::transformOcTree;
using octomap::OcTree;

namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

Vector3d centreOf(const VoxelIndex& v, double resolution) {
  return resolution * (Vector3d(v[0], v[1], v[2]).array() + 0.5).matrix();
}

VoxelIndex voxelAt(const Vector3d& p, double resolution) {
  const auto index = [&](int axis) { return static_cast<int>(std::floor(p[axis] / resolution)); };
  return {index(0), index(1), index(2)};
}

/** A voxel map as an array over its bounding box: the twins below look up millions of voxels. */
class DenseVoxels {
 public:
  explicit DenseVoxels(const VoxelMap& voxels) {
    low_ = high_ = voxels.begin()->first;
    for (const auto& [k, v] : voxels)
      for (int a = 0; a < 3; a++) {
        low_[a] = std::min(low_[a], k[a]);
        high_[a] = std::max(high_[a], k[a]);
      }
    values_.assign(static_cast<size_t>(side(0)) * side(1) * side(2), kUnknown);
    for (const auto& [k, v] : voxels) values_[indexOf(k)] = v;
  }
  const VoxelIndex& low() const { return low_; }
  const VoxelIndex& high() const { return high_; }
  /** The log-odds; NaN if unknown. */
  float at(const VoxelIndex& k) const {
    for (int a = 0; a < 3; a++)
      if (k[a] < low_[a] || k[a] > high_[a]) return kUnknown;
    return values_[indexOf(k)];
  }

 private:
  int side(int a) const { return high_[a] - low_[a] + 1; }
  size_t indexOf(const VoxelIndex& k) const {
    return (static_cast<size_t>(k[0] - low_[0]) * side(1) + (k[1] - low_[1])) * side(2) +
           (k[2] - low_[2]);
  }

  VoxelIndex low_, high_;
  std::vector<float> values_;
};

/** The transform's twin: one look at the source per voxel (or lattice of samples, if the voxels are
 * larger than the source's) of the box around the moved map, and nothing clever. */
VoxelMap lookedUp(const DenseVoxels& source, double source_resolution, const Isometry3d& T,
                  double resolution) {
  Eigen::AlignedBox3d box;
  for (int corner = 0; corner < 8; corner++) {
    Vector3d p;
    for (int a = 0; a < 3; a++)
      p[a] = source_resolution * ((corner >> a) & 1 ? source.high()[a] + 1 : source.low()[a]);
    box.extend(T * p);
  }
  const int samples =
      std::max(1, static_cast<int>(std::ceil(resolution / source_resolution - 1e-9)));
  const Isometry3d inverse = T.inverse();
  const VoxelIndex low = voxelAt(box.min(), resolution), high = voxelAt(box.max(), resolution);
  VoxelMap voxels;
  for (int x = low[0]; x <= high[0]; x++)
    for (int y = low[1]; y <= high[1]; y++)
      for (int z = low[2]; z <= high[2]; z++) {
        float highest = kUnknown;
        for (int s = 0; s < samples * samples * samples; s++) {
          const Vector3d offset(s % samples, s / samples % samples, s / samples / samples);
          const Vector3d p = (Vector3d(x, y, z).array() + (offset.array() + 0.5) / samples);
          highest =
              std::fmax(highest, source.at(voxelAt(inverse * (p * resolution), source_resolution)));
        }
        if (!std::isnan(highest)) voxels[{x, y, z}] = highest;
      }
  return voxels;
}

bool isOccupied(float log_odds) {
  static const float threshold = OcTree(1).getOccupancyThresLog();
  return log_odds >= threshold;
}

/** Distance from a point to the nearest occupied voxel centre, if there is one within a voxel's
 * diagonal; else infinity. */
double distanceToOccupied(const DenseVoxels& voxels, double resolution, const Vector3d& p) {
  const VoxelIndex home = voxelAt(p, resolution);
  double least = HUGE_VAL;
  for (int dx = -2; dx <= 2; dx++)
    for (int dy = -2; dy <= 2; dy++)
      for (int dz = -2; dz <= 2; dz++) {
        const VoxelIndex k{home[0] + dx, home[1] + dy, home[2] + dz};
        if (isOccupied(voxels.at(k))) least = std::min(least, (centreOf(k, resolution) - p).norm());
      }
  return least;
}

/** For each voxel that contains the moved centre of an occupied source voxel without an occupied
 * voxel within half a diagonal in \a looked_up: the highest value of those. */
VoxelMap thinObstacles(const VoxelMap& source, double source_resolution, const Isometry3d& T,
                       const DenseVoxels& looked_up, double resolution) {
  VoxelMap thin;
  for (const auto& [k, v] : source) {
    if (!isOccupied(v)) continue;
    const Vector3d p = T * centreOf(k, source_resolution);
    if (distanceToOccupied(looked_up, resolution, p) <= std::sqrt(0.75) * resolution) continue;
    auto& value = thin.emplace(voxelAt(p, resolution), v).first->second;
    value = std::max(value, v);
  }
  return thin;
}

Isometry3d pose(double x, double y, double z, double yaw, double pitch = 0, double roll = 0) {
  Isometry3d T = Isometry3d::Identity();
  T.translation() << x, y, z;
  T.linear() =
      (Eigen::AngleAxisd(yaw, Vector3d::UnitZ()) * Eigen::AngleAxisd(pitch, Vector3d::UnitY()) *
       Eigen::AngleAxisd(roll, Vector3d::UnitX()))
          .toRotationMatrix();
  return T;
}

/** None takes the new voxels' centres to the very faces of the source's, where rounding decides. */
const std::vector<Isometry3d> kPoses = {
    pose(0.537, -1.219, 0.313, 0),
    pose(0, 0, 0.0137, 0.7853),
    pose(-3.21, 0.77, 1.08, 1.1, 0.4, -0.6),
    pose(1.05, 2.02, -0.513, 0.0123),
    pose(1214.9, -987.6, 33.3, -2.9, 0.05, 0.02),
};

/** The 24 rotations that take the grid's axes to each other. */
std::vector<Eigen::Matrix3d> axisRotations() {
  std::vector<Eigen::Matrix3d> rotations;
  for (int x = 0; x < 6; x++)
    for (int y = 0; y < 6; y++) {
      if (x % 3 == y % 3) continue;
      const Vector3d a = (x < 3 ? 1 : -1) * Vector3d::Unit(x % 3);
      const Vector3d b = (y < 3 ? 1 : -1) * Vector3d::Unit(y % 3);
      Eigen::Matrix3d r;
      r << a, b, a.cross(b);
      rotations.push_back(r);
    }
  return rotations;
}

/** The tree with its inner nodes and pruning in order. */
OcTree finished(const OcTree& tree) {
  OcTree copy(tree);
  finish(copy);
  return copy;
}

struct Resolutions {
  double source, result;
};
std::ostream& operator<<(std::ostream& o, const Resolutions& r) {
  return o << r.source << "_to_" << r.result;
}

}  // namespace

// ---------------------------------------------------------------- exact cases

TEST(TransformOcTree, IdentityGivesThePrunedSource) {
  for (const double resolution : {0.1, 1 / 3., 0.25}) {
    for (unsigned seed = 0; seed < 3; seed++) {
      const auto source = sceneTree(resolution, seed);
      EXPECT_TRUE(sameTree(*source, *transformOcTree(*source, Isometry3d::Identity(), resolution)));
    }
    const auto awkward = awkwardTree(resolution);
    const auto result = transformOcTree(*awkward, Isometry3d::Identity(), resolution);
    EXPECT_TRUE(sameNodes(leavesOf(finished(*awkward)), leavesOf(*result)));
  }
}

TEST(TransformOcTree, MovesByWholeVoxelsExactly) {
  for (const double resolution : {0.1, 1 / 3., 0.25}) {
    const auto source = sceneTree(resolution, 3);
    const auto voxels = voxelsOf(*source);
    for (const VoxelIndex& shift : {VoxelIndex{1, 0, 0}, VoxelIndex{-45, 33, -7},
                                    VoxelIndex{8, -16, 32}, VoxelIndex{12345, -9876, 4321}}) {
      Isometry3d T = Isometry3d::Identity();
      T.translation() = resolution * Vector3d(shift[0], shift[1], shift[2]);
      VoxelMap expected;
      for (const auto& [k, v] : voxels)
        expected[{k[0] + shift[0], k[1] + shift[1], k[2] + shift[2]}] = v;
      const auto result = transformOcTree(*source, T, resolution);
      EXPECT_TRUE(sameVoxels(expected, voxelsOf(*result)));
      EXPECT_TRUE(sameTree(finished(*result), *result));
    }
  }
}

TEST(TransformOcTree, TurnsByRightAnglesExactly) {
  const auto source = sceneTree(0.1, 4);
  const auto voxels = voxelsOf(*source);
  const auto rotations = axisRotations();
  ASSERT_EQ(24U, rotations.size());
  for (const auto& rotation : rotations) {
    Isometry3d T = Isometry3d::Identity();
    T.linear() = rotation;
    T.translation() << 0.7, -2.3, 1.9;
    VoxelMap expected;
    for (const auto& [k, v] : voxels) expected[voxelAt(T * centreOf(k, 0.1), 0.1)] = v;
    ASSERT_EQ(voxels.size(), expected.size());
    EXPECT_TRUE(sameVoxels(expected, voxelsOf(*transformOcTree(*source, T, 0.1)))) << rotation;
  }
}

TEST(TransformOcTree, HalfTheResolutionTakesTheHighestOfEight) {
  const auto source = sceneTree(0.1, 5);
  VoxelMap expected;
  for (const auto& [k, v] : voxelsOf(*source)) {
    auto& value = expected.emplace(voxelAt(centreOf(k, 0.1), 0.2), v).first->second;
    value = std::max(value, v);
  }
  EXPECT_TRUE(
      sameVoxels(expected, voxelsOf(*transformOcTree(*source, Isometry3d::Identity(), 0.2))));
}

TEST(TransformOcTree, TwiceTheResolutionCopiesEachVoxelEightTimes) {
  const auto source = sceneTree(0.1, 6);
  VoxelMap expected;
  for (const auto& [k, v] : voxelsOf(*source))
    for (int i = 0; i < 8; i++)
      expected[{2 * k[0] + (i & 1), 2 * k[1] + ((i >> 1) & 1), 2 * k[2] + (i >> 2)}] = v;
  EXPECT_TRUE(
      sameVoxels(expected, voxelsOf(*transformOcTree(*source, Isometry3d::Identity(), 0.05))));
}

TEST(TransformOcTree, AnEmptyTreeStaysEmpty) {
  const auto result = transformOcTree(OcTree(0.1), kPoses[2], 0.2);
  EXPECT_EQ(0U, result->size());
  EXPECT_EQ(0.2, result->getResolution());
}

// ---------------------------------------------------------------- any pose, any resolution

class TransformOcTreeResolutions : public testing::TestWithParam<Resolutions> {};
INSTANTIATE_TEST_SUITE_P(Pairs, TransformOcTreeResolutions,
                         testing::Values(Resolutions{0.1, 0.1}, Resolutions{0.1, 0.2},
                                         Resolutions{0.1, 0.05}, Resolutions{0.08, 0.1},
                                         Resolutions{0.1, 0.08}, Resolutions{0.1, 0.27}));

TEST_P(TransformOcTreeResolutions, LooksUpTheSourceAtEachVoxelAndKeepsThinObstacles) {
  const auto [from, to] = GetParam();
  size_t thin_voxels = 0;
  for (size_t i = 0; i < kPoses.size(); i++) {
    SCOPED_TRACE(i);
    const auto source = sceneTree(from, static_cast<unsigned>(i));
    const auto source_voxels = voxelsOf(*source);
    const auto looked_up = lookedUp(DenseVoxels(source_voxels), from, kPoses[i], to);
    const auto thin = thinObstacles(source_voxels, from, kPoses[i], DenseVoxels(looked_up), to);
    const auto result = voxelsOf(*transformOcTree(*source, kPoses[i], to));
    ASSERT_GT(looked_up.size(), 500U);

    // What the thin-obstacle rule changed must be as that rule says, all else as looked up.
    VoxelMap explained = looked_up;
    for (const auto& [k, v] : thin) {
      const auto it = result.find(k);
      if (it != result.end() && it->second == v) explained[k] = v;
    }
    EXPECT_TRUE(sameVoxels(explained, result));
    thin_voxels += thin.size();
  }
  // Voxels fall between the samples if those are about as far apart as the voxels are wide.
  if (to <= from && std::sqrt(3.0) * to > from) {
    EXPECT_GT(thin_voxels, 0U);
  }
}

TEST_P(TransformOcTreeResolutions, EveryObstacleHasACounterpartWithinHalfADiagonal) {
  const auto [from, to] = GetParam();
  const double reach = std::sqrt(0.75) * std::max(from, to) + 1e-9;
  for (size_t i = 0; i < kPoses.size(); i++) {
    const auto source = sceneTree(from, static_cast<unsigned>(i));
    const DenseVoxels result(voxelsOf(*transformOcTree(*source, kPoses[i], to)));
    size_t occupied = 0, lost = 0;
    double farthest = 0;
    for (const auto& [k, v] : voxelsOf(*source)) {
      if (!isOccupied(v)) continue;
      occupied++;
      const double d = distanceToOccupied(result, to, kPoses[i] * centreOf(k, from));
      lost += d > reach;
      farthest = std::max(farthest, d);
    }
    EXPECT_EQ(0U, lost) << "of " << occupied << " at pose " << i << ", up to " << farthest << " m";
  }
}

TEST_P(TransformOcTreeResolutions, NoObstacleIsInventedBeyondHalfADiagonal) {
  const auto [from, to] = GetParam();
  // On a coarser grid a voxel takes the highest of several samples, not that at its centre.
  const double reach = std::sqrt(0.75) * (to > from ? from + to : from) + 1e-9;
  for (size_t i = 0; i < kPoses.size(); i++) {
    const auto source = sceneTree(from, static_cast<unsigned>(i));
    const DenseVoxels source_voxels(voxelsOf(*source));
    size_t occupied = 0, invented = 0;
    double farthest = 0;
    for (const auto& [k, v] : voxelsOf(*transformOcTree(*source, kPoses[i], to))) {
      if (!isOccupied(v)) continue;
      occupied++;
      const double d =
          distanceToOccupied(source_voxels, from, kPoses[i].inverse() * centreOf(k, to));
      invented += d > reach;
      farthest = std::max(farthest, d);
    }
    EXPECT_EQ(0U, invented) << "of " << occupied << " at pose " << i << ", up to " << farthest
                            << " m";
  }
}

TEST_P(TransformOcTreeResolutions, UnknownSpaceStaysUnknown) {
  const auto [from, to] = GetParam();
  for (size_t i = 0; i < kPoses.size(); i++) {
    const auto source = sceneTree(from, static_cast<unsigned>(i));
    const DenseVoxels known(voxelsOf(*source));
    const int reach = static_cast<int>(std::ceil(to / from)) + 1;
    for (const auto& [k, v] : voxelsOf(*transformOcTree(*source, kPoses[i], to))) {
      // The nearest known voxel of the source, as a cube, to where this voxel's centre came from.
      const Vector3d p = kPoses[i].inverse() * centreOf(k, to);
      const VoxelIndex home = voxelAt(p, from);
      double nearest = HUGE_VAL;
      if (!std::isnan(known.at(home))) continue;
      for (int dx = -reach; dx <= reach; dx++)
        for (int dy = -reach; dy <= reach; dy++)
          for (int dz = -reach; dz <= reach; dz++) {
            const VoxelIndex n{home[0] + dx, home[1] + dy, home[2] + dz};
            if (std::isnan(known.at(n))) continue;
            const Vector3d outside =
                ((p - centreOf(n, from)).cwiseAbs().array() - 0.5 * from).cwiseMax(0);
            nearest = std::min(nearest, outside.norm());
          }
      ASSERT_LE(nearest, std::sqrt(0.75) * to + 1e-9) << "at pose " << i;
    }
  }
}

TEST_P(TransformOcTreeResolutions, LeavesTheSourceAsItWasAndGivesItsSensorModel) {
  const auto [from, to] = GetParam();
  const auto source = sceneTree(from, 9);
  mrpt::fusion::OcTreeAccess::setSensorModel(
      *source, {-1.2345678F, 2.5678912F, 0.91234567F, -0.3456789F, 0.1234567F});
  const auto before = nodesOf(*source);
  const auto result = transformOcTree(*source, kPoses[2], to);
  EXPECT_TRUE(sameNodes(before, nodesOf(*source)));
  EXPECT_EQ(sensorModelBits(*source), sensorModelBits(*result));
  EXPECT_EQ(to, result->getResolution());
}

TEST_P(TransformOcTreeResolutions, GivesAPrunedTreeOfSourceValues) {
  const auto [from, to] = GetParam();
  const auto source = sceneTree(from, 10);
  // Beyond the clamping thresholds: what is kept must be kept as it is.
  for (const VoxelIndex& k : {VoxelIndex{25, 25, 25}, VoxelIndex{-26, 25, 20}})
    putVoxel(*source, k, 8.5F + static_cast<float>(k[2]));
  putVoxel(*source, {0, 0, 20}, -9.5F);
  source->updateInnerOccupancy();
  std::set<uint32_t> values;
  for (const auto& leaf : leavesOf(*source)) values.insert(leaf.bits);
  for (const auto& T : kPoses) {
    const auto result = transformOcTree(*source, T, to);
    EXPECT_TRUE(sameTree(finished(*result), *result));
    for (const auto& leaf : leavesOf(*result)) ASSERT_TRUE(values.count(leaf.bits)) << leaf;
  }
}

// ---------------------------------------------------------------- the same bits

namespace {

/** Poses that turn, tilt, swap axes, and take centres to the very faces of the source's voxels. */
std::vector<Isometry3d> posesForBits() {
  std::vector<Isometry3d> poses = kPoses;
  poses.push_back(Isometry3d::Identity());
  poses.push_back(pose(0.05, -0.05, 0.15, 0));
  poses.push_back(pose(1.3, 0.2, -0.4, M_PI / 2));
  poses.push_back(pose(-0.3, 0.35, 0, 0.3, 1.4, -2.2));
  std::mt19937 rng(91);
  std::uniform_real_distribution<double> angle(-3.1, 3.1), shift(-50, 50);
  for (int i = 0; i < 4; i++)
    poses.push_back(pose(shift(rng), shift(rng), shift(rng), angle(rng), angle(rng), angle(rng)));
  return poses;
}

/** Known and unknown voxels and leaves of many sizes at random. */
std::unique_ptr<OcTree> randomTree(double resolution, unsigned seed) {
  auto tree = std::make_unique<OcTree>(resolution);
  std::mt19937 rng(seed);
  std::uniform_int_distribution<int> place(-40, 39), number(0, 3);
  const float values[] = {-2.F, -0.4F, 0.85F, 3.5F};
  for (int i = 0; i < 40; i++) {
    const int size = 1 << number(rng) << number(rng) % 3;  // up to 32 voxels
    VoxelIndex corner{place(rng), place(rng), place(rng)};
    const float value = values[number(rng)];
    const unsigned depth = 16 - static_cast<unsigned>(std::lround(std::log2(size)));
    for (int& c : corner) c = static_cast<int>(std::floor(static_cast<double>(c) / size)) * size;
    if (const auto* known = tree->search(keyOf(corner)); known || tree->size() > 20000) continue;
    putLeaf(*tree, corner, depth, value);
  }
  for (int i = 0; i < 2000; i++) {
    const VoxelIndex voxel{place(rng), place(rng), place(rng) / 4};
    if (!tree->search(keyOf(voxel))) putVoxel(*tree, voxel, values[number(rng)]);
  }
  return tree;
}

}  // namespace

TEST_P(TransformOcTreeResolutions, HasTheBitsOfItsTwin) {
  const auto [from, to] = GetParam();
  unsigned seed = 0;
  for (const auto& T : posesForBits()) {
    SCOPED_TRACE(testing::Message() << "pose " << seed);
    const auto scene = sceneTree(from, seed), random = randomTree(from, seed++);
    for (const auto* source : {scene.get(), random.get()}) {
      const auto expected = reference::transformed(*source, T, to);
      EXPECT_TRUE(sameTree(*expected, *transformOcTree(*source, T, to)));
    }
  }
}

TEST(TransformOcTree, HasTheBitsOfItsTwinForVeryDifferentResolutions) {
  const auto source = sceneTree(0.1, 8);
  for (const double to : {0.02, 0.03, 0.39, 0.41, 0.9})
    for (const auto& T : {kPoses[1], kPoses[2], Isometry3d::Identity()})
      EXPECT_TRUE(
          sameTree(*reference::transformed(*source, T, to), *transformOcTree(*source, T, to)))
          << to;
}

TEST(TransformOcTree, HasTheBitsOfItsTwinForAwkwardTrees) {
  const auto source = awkwardTree(0.1);
  for (const auto& T : {pose(102.4, -204.8, 0, 0), Isometry3d::Identity()})
    EXPECT_TRUE(
        sameTree(*reference::transformed(*source, T, 0.1), *transformOcTree(*source, T, 0.1)));
}

TEST(TransformOcTree, IsTheSameForAnyNumberOfThreads) {
  const auto source = sceneTree(0.1, 12);
  const auto expected = reference::transformed(*source, kPoses[2], 0.1);
  for (const size_t threads : {1, 2, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_TRUE(sameTree(*expected, *transformOcTree(*source, kPoses[2], 0.1)));
  }
}

// ---------------------------------------------------------------- there and back

TEST(TransformOcTree, ThereAndBackKeepsObstaclesWithinOneVoxelAndInventsNone) {
  for (size_t i = 0; i < kPoses.size(); i++)
    for (unsigned seed = 20; seed < 23; seed++) {
      const auto source = sceneTree(0.1, seed);
      const auto there = transformOcTree(*source, kPoses[i], 0.1);
      const auto back = transformOcTree(*there, kPoses[i].inverse(), 0.1);
      const auto before = voxelsOf(*source), after = voxelsOf(*back);
      const auto withoutNeighbour = [](const VoxelMap& from, const VoxelMap& in) {
        const DenseVoxels dense(in);
        size_t alone = 0;
        for (const auto& [k, v] : from) {
          if (!isOccupied(v)) continue;
          bool found = false;
          for (int n = 0; n < 27 && !found; n++)
            found =
                isOccupied(dense.at({k[0] + n % 3 - 1, k[1] + n / 3 % 3 - 1, k[2] + n / 9 - 1}));
          alone += !found;
        }
        return alone;
      };
      EXPECT_EQ(0U, withoutNeighbour(before, after)) << "lost at pose " << i << " seed " << seed;
      EXPECT_EQ(0U, withoutNeighbour(after, before))
          << "invented at pose " << i << " seed " << seed;
    }
}

TEST(TransformOcTree, ALoneVoxelIsNeverLost) {
  std::mt19937 rng(77);
  std::uniform_real_distribution<double> angle(-3.1, 3.1), shift(-5, 5);
  OcTree source(0.1);
  putVoxel(source, {13, -8, 5}, 8.5F);  // more than OctoMap's setters would let pass
  finish(source);
  for (int i = 0; i < 2000; i++) {
    const auto T = pose(shift(rng), shift(rng), shift(rng), angle(rng), angle(rng), angle(rng));
    const auto result = transformOcTree(source, T, 0.1);
    const auto voxels = voxelsOf(*result);
    ASSERT_GE(voxels.size(), 1U);
    for (const auto& [k, v] : voxels) {
      ASSERT_EQ(8.5F, v);
      ASSERT_LE((centreOf(k, 0.1) - T * centreOf({13, -8, 5}, 0.1)).norm(), 0.0867);
    }
  }
}

TEST(TransformOcTree, ALonePrunedBlockIsKeptToItsCorners) {
  // Each of the voxels that a pruned leaf stands for has its counterpart, as lone voxels do.
  std::mt19937 rng(78);
  std::uniform_real_distribution<double> angle(-3.1, 3.1), shift(-5, 5);
  OcTree source(0.1);
  putLeaf(source, {12, -8, 4}, 15, 0.25F);
  finish(source);
  int lost = 0;
  double farthest = 0;
  for (int i = 0; i < 2000; i++) {
    const auto T = pose(shift(rng), shift(rng), shift(rng), angle(rng), angle(rng), angle(rng));
    const DenseVoxels result(voxelsOf(*transformOcTree(source, T, 0.1)));
    for (const auto& [k, v] : voxelsOf(source)) {
      const double d = distanceToOccupied(result, 0.1, T * centreOf(k, 0.1));
      lost += d > std::sqrt(0.75) * 0.1 + 1e-9;
      farthest = std::max(farthest, d);
    }
  }
  EXPECT_EQ(0, lost) << "of 16000, up to " << farthest << " m";
}

// ---------------------------------------------------------------- large leaves

TEST(TransformOcTree, AHugeLeafIsMovedWhole) {
  for (const double resolution : {0.1, 1 / 3.})
    for (const unsigned depth : {2U, 3U, 4U}) {
      const int side = 1 << (16 - depth);
      OcTree source(resolution);
      putLeaf(source, {-side, -side, -side}, depth, 2.5F);
      finish(source);
      // By its own side, and by a part of it: an 8th, so that it is made of 8 x 8 x 8 cubes.
      for (const int shift : {0, side, side / 8}) {
        if (-side + shift + side > 16384) continue;
        Isometry3d T = Isometry3d::Identity();
        T.translation().setConstant(shift * resolution);
        const auto result = transformOcTree(source, T, resolution);
        EXPECT_LT(result->size(), 1000U);
        double volume = 0;
        for (auto it = result->begin_leafs(); it != result->end_leafs(); ++it) {
          EXPECT_EQ(2.5F, it->getLogOdds());
          volume += std::pow(1 << (16 - it.getDepth()), 3);
        }
        EXPECT_EQ(std::pow(side, 3), volume);
        double low[3], high[3];
        result->getMetricMin(low[0], low[1], low[2]);
        result->getMetricMax(high[0], high[1], high[2]);
        for (int a = 0; a < 3; a++) {
          EXPECT_NEAR((shift - side) * resolution, low[a], 1e-6);
          EXPECT_NEAR(shift * resolution, high[a], 1e-6);
        }
      }
    }
}

TEST(TransformOcTree, ALargeLeafIsTurnedAtTheCostOfItsFaces) {
  OcTree source(0.1);
  putLeaf(source, {0, 0, 0}, 8, -1.5F);  // 256 voxels wide: 16.8 million of them
  finish(source);
  const auto result = transformOcTree(source, pose(3.3, -1.2, 0.4, 0.5, 0.1, 0), 0.1);
  double volume = 0;
  for (auto it = result->begin_leafs(); it != result->end_leafs(); ++it) {
    EXPECT_EQ(-1.5F, it->getLogOdds());
    volume += std::pow(1 << (16 - it.getDepth()), 3);
  }
  EXPECT_NEAR(1, volume / std::pow(256, 3), 0.001);
  EXPECT_LT(result->size(), 6U * 256 * 256 * 3);
}

TEST(TransformOcTree, ALeafWithBillionsOfFaceVoxelsIsAnError) {
  for (const unsigned depth : {4U, 5U})
    for (const float log_odds : {-1.5F, 1.5F}) {
      OcTree source(0.1);
      putLeaf(source, {0, 0, 0}, depth, log_odds);
      finish(source);
      const Isometry3d turned = pose(3.3, -1.2, 0.4, 0.5, 0.1, 0);
      EXPECT_THROW(transformOcTree(source, turned, 0.1), std::length_error) << depth;
      EXPECT_NO_THROW(transformOcTree(source, pose(0, 0, 0, 0), 0.1)) << depth;
    }
}

TEST(TransformOcTree, UnprunedLeavesWithBillionsOfFaceVoxelsAreAnError) {
  OcTree source(0.1);
  for (int x = 0; x < 32; x++)
    for (int y = 0; y < 32; y++)
      for (int z = 0; z < 16; z++) putLeaf(source, {64 * x, 64 * y, 64 * z}, 10, 1.5F);
  EXPECT_THROW(transformOcTree(source, pose(0.05, 0, 0, 0), 0.1), std::length_error);
}

TEST(TransformOcTree, AMapMayBeRefinedAndCoarsened) {
  const auto source = sceneTree(0.1, 4);
  for (const double resolution : {0.0125, 0.8, 3.2})
    EXPECT_NO_THROW(transformOcTree(*source, pose(1, 2, 0.3, 0.5, 0.1, 0.2), resolution))
        << resolution;
}

// ---------------------------------------------------------------- the grid's edge, bad arguments

TEST(TransformOcTree, AMapThatReachesTheGridsEdgesFits) {
  OcTree source(0.1);
  putVoxel(source, {-32768, -32768, -32768}, 1.0F);
  putVoxel(source, {32767, 32767, 32767}, 1.5F);
  finish(source);
  std::unique_ptr<OcTree> result;
  ASSERT_NO_THROW(result = transformOcTree(source, Isometry3d::Identity(), 0.1));
  EXPECT_TRUE(sameTree(source, *result));
}

TEST(TransformOcTree, AMapMovedOutOfTheGridThrows) {
  const auto source = smallTree();
  EXPECT_NO_THROW(transformOcTree(*source, pose(3200, 0, 0, 0.3), 0.1));
  EXPECT_THROW(transformOcTree(*source, pose(3300, 0, 0, 0.3), 0.1), std::out_of_range);
  EXPECT_THROW(transformOcTree(*source, pose(0, -3300, 0, 0), 0.1), std::out_of_range);
  EXPECT_THROW(transformOcTree(*source, pose(0, 0, 1e12, 0), 0.1), std::out_of_range);
  // The same map on a grid too fine for its 13 m.
  EXPECT_NO_THROW(transformOcTree(*source, Isometry3d::Identity(), 0.001));
  EXPECT_THROW(transformOcTree(*source, Isometry3d::Identity(), 0.0001), std::out_of_range);
}

TEST(TransformOcTree, ATransformThatIsNotFiniteThrows) {
  const auto source = smallTree();
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL})
    for (int row = 0; row < 3; row++)
      for (int column = 0; column < 4; column++) {
        Isometry3d T = Isometry3d::Identity();
        T.matrix()(row, column) = bad;
        EXPECT_THROW(transformOcTree(*source, T, 0.1), std::invalid_argument);
      }
}

TEST(TransformOcTree, VoxelsThatAreSamplesByTheMillionThrow) {
  const auto source = smallTree();
  EXPECT_NO_THROW(transformOcTree(*source, Isometry3d::Identity(), 6.4));
  EXPECT_THROW(transformOcTree(*source, Isometry3d::Identity(), 6.5), std::invalid_argument);
}

TEST(TransformOcTree, AResolutionThatIsNoLengthThrows) {
  for (const double resolution : {0.0, -0.1, std::nan(""), HUGE_VAL})
    EXPECT_THROW(transformOcTree(*smallTree(), Isometry3d::Identity(), resolution),
                 std::invalid_argument);
}
