// SPDX-License-Identifier: BSD-3-Clause
#include "kinds.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "csv.h"
#include "pmm_methods.h"

namespace mrpt::fusion::benchmark {
namespace {

using Tree = std::shared_ptr<const octomap::OcTree>;

Tree withoutFreeSpace(const Tree& map) {
  return changed(*map, [](const auto&, float l) { return l >= 0 ? l : NAN; });
}

/** Returns the layer of voxels at the height \a z, m. */
Tree oneLayer(const Tree& map, double z) {
  const octomap::key_type layer = map->coordToKey(z);
  return changed(*map, [=](const auto& key, float l) { return key[2] == layer ? l : NAN; });
}

/** Returns the median height of the obstacles, m. */
double medianHeight(const octomap::OcTree& map) {
  std::vector<float> heights;
  for (const auto& c : extractOccupiedVoxels(map).centre) heights.push_back(c.z());
  if (heights.empty()) return 0;
  const auto middle = heights.begin() + static_cast<std::ptrdiff_t>((heights.size() - 1) / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  return *middle;
}

/** Cuts both maps to the layer at A's median height. Needs maps with a common vertical. */
void cutToOneLayer(MapPair& pair) {
  const double z = medianHeight(*pair.a);
  const Eigen::Vector3d middle = pair.T_a_b * pair.centre_of_b;
  const double z_b = (pair.T_a_b.inverse() * Eigen::Vector3d(middle.x(), middle.y(), z)).z();
  pair.a = oneLayer(pair.a, z);
  pair.b = oneLayer(pair.b, z_b);
}

/** Puts B's obstacles at the heights of A's obstacles, for maps without a true pose. */
void levelWithA(MapPair& pair) {
  pair.centre_of_b.setZero();
  pair.T_a_b.setIdentity();
  pair.T_a_b.translation().z() = medianHeight(*pair.a) - medianHeight(*pair.b);
}

bool isUpright(const MapPair& pair) {
  constexpr double kLeastCosine = 0.9998;  // 1.1 deg
  return pair.T_a_b.linear()(2, 2) > kLeastCosine;
}

std::vector<std::pair<std::string, std::function<void(MapPair&)>>> kindsOf(const MapPair& pair) {
  using Change = std::function<Tree(const Tree&)>;
  const auto both = [](const Change& change) {
    return [=](MapPair& p) {
      p.a = change(p.a);
      p.b = change(p.b);
    };
  };
  const auto coarsened = [](double factor) {
    return [=](const Tree& map) { return resampled(*map, factor * map->getResolution()); };
  };
  const auto sparse = [](const Tree& map) { return withAThirdOfObstacles(*map); };
  std::vector<std::pair<std::string, std::function<void(MapPair&)>>> kinds = {
      {"as it is", [](MapPair&) {}},
      {"voxels twice as wide", both(coarsened(2))},
      {"voxels 4 times as wide", both(coarsened(4))},
      {"no free space", both(withoutFreeSpace)},
      {"no free space in B", [](MapPair& p) { p.b = withoutFreeSpace(p.b); }},
      {"a third of the obstacles", both(sparse)}};
  if (isUpright(pair)) kinds.emplace_back("one layer", cutToOneLayer);
  return kinds;
}

}  // namespace

void judgeKinds(const MapPair& pair, const std::vector<MapPair>& others, const Effort& effort,
                std::ostream& csv) {
  constexpr unsigned kParts = 24;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  writeRow(csv,
           "dataset,kind,case,overlap,error_m,error_deg,scale,probability,verdict,matched_overlap,"
           "conflict_ratio,runner_up,inlier_ratio,missed_ratio,without_free,rival_support,"
           "rival_same_side,size_ratio");
  const auto judge = [&](const std::string& kind, const std::string& of, const MapPair& maps,
                         bool has_truth) {
    if (extractOccupiedVoxels(*maps.a).size() == 0 || extractOccupiedVoxels(*maps.b).size() == 0)
      return;
    const auto method = makeMethod("anywhere");
    method->prepare(maps);
    const Registration r = method->align(Eigen::Isometry3d::Identity());
    const PoseError error = errorOf(r.T_a_b, maps);
    writeRow(csv, pair.name, kind, of, has_truth ? trueOverlap(maps) : 0,
             has_truth ? error.centre : kInfinity, error.angle * 180 / M_PI, r.scale, r.probability,
             verdictText(r.accepted), r.overlap, r.conflict_ratio, r.runner_up, r.inlier_ratio,
             r.missed_ratio, r.without_free, r.rival_support, r.rival_same_side, r.size_ratio);
  };
  for (const auto& [kind, change] : kindsOf(pair)) {
    if (!effort.kind.empty() && kind != effort.kind) continue;
    std::mt19937 generator(7);
    size_t stranger = 0;
    for (unsigned i = 0; i < kParts; i++) {
      const MapPair parts = i == 0 ? pair : randomParts(pair, generator);
      if (i % effort.stride != 0) continue;
      const std::string part = "part " + std::to_string(i);
      const auto judgeWith = [&](const std::string& of, const Tree& b, bool has_truth) {
        MapPair maps = parts;
        maps.b = b;
        if (!has_truth) levelWithA(maps);
        change(maps);
        judge(kind, of, maps, has_truth);
      };
      judgeWith(part, parts.b, true);
      judgeWith("mirror image of " + part, mirrored(*parts.b), false);
      if (others.empty()) continue;
      const MapPair& other = others[stranger++ % others.size()];
      judgeWith(other.name + " for " + part, other.b, false);
    }
  }
}

}  // namespace mrpt::fusion::benchmark
