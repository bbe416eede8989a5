// SPDX-License-Identifier: BSD-3-Clause
#include "map_pair.h"

#include <mrpt/fusion/map_files.h>
#include <mrpt/fusion/voxels.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <stdexcept>

#include "fusion_core/registration/association.h"
#include "fusion_octree/build.h"
#include "fusion_octree/resampling.h"

namespace mrpt::fusion::benchmark {
namespace {

namespace fs = std::filesystem;

/** Keeps what lies on one side of a plane. */
class CropVisitor {
 public:
  using State = const octomap::OcTreeNode*;

  CropVisitor(const octomap::OcTree& map, const Eigen::Vector3d& direction, double offset)
      : map_(map), direction_(direction), offset_(offset) {}

  mrpt::fusion::OcTreeFill visit(const mrpt::fusion::OcTreeCube& cube, State node) const {
    using mrpt::fusion::OcTreeFill;
    if (!node) return OcTreeFill::unknown();
    const double half = 0.5 * cube.side() * map_.getResolution();
    const octomap::point3d low = map_.keyToCoord(cube.key);  // the middle of its first voxel
    const Eigen::Vector3d middle =
        Eigen::Vector3d(low.x(), low.y(), low.z()).array() + half - 0.5 * map_.getResolution();
    const double depth = direction_.dot(middle) - offset_;
    const double reach = half * direction_.lpNorm<1>();
    if (depth <= -reach) return OcTreeFill::unknown();
    if (map_.nodeHasChildren(node) || (depth < reach && cube.depth < cube.kMaxDepth))
      return OcTreeFill::split();
    return depth > 0 ? OcTreeFill::leaf(node->getLogOdds()) : OcTreeFill::unknown();
  }

  State descend(State node, unsigned i, const mrpt::fusion::OcTreeCube&) const {
    return mrpt::fusion::childOrSelf(map_, node, i);
  }

 private:
  const octomap::OcTree& map_;
  Eigen::Vector3d direction_;
  double offset_;
};

}  // namespace

std::shared_ptr<const octomap::OcTree> loadTree(const std::string& path) {
  const auto map = mrpt::fusion::loadMap(path);
  return {map, &map->octree()};
}

Eigen::Isometry3d loadPose(const std::string& path) {
  std::ifstream file(path);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int row = 0; row < 4; row++)
    for (int column = 0; column < 4; column++) file >> T.matrix()(row, column);
  if (!file) throw std::runtime_error(path + ": is not a 4x4 matrix");
  return T;
}

MapPair loadMapPair(const std::string& folder) {
  MapPair pair;
  pair.folder = folder;
  pair.name = fs::absolute(folder + "/.").parent_path().filename().string();
  const auto map = [&](const std::string& name) {
    const std::string path = folder + "/" + name;
    return loadTree(fs::exists(path + ".bt") ? path + ".bt" : path + ".ot");
  };
  pair.a = map("map_a");
  pair.b = map("map_b");
  pair.T_a_b = loadPose(folder + "/T_a_b.txt");
  const OccupiedVoxels voxels = extractOccupiedVoxels(*pair.b);
  if (voxels.size() == 0) throw std::runtime_error(folder + ": map b has no occupied voxel");
  for (const auto& c : voxels.centre) pair.centre_of_b += c.cast<double>();
  pair.centre_of_b /= static_cast<double>(voxels.size());
  return pair;
}

Eigen::Isometry3d poseOf(const Start& start, const MapPair& pair) {
  const Eigen::Vector3d middle = pair.T_a_b * pair.centre_of_b;
  return Eigen::Translation3d(middle + Eigen::Vector3d(start.dx, start.dy, 0)) *
         Eigen::AngleAxisd(start.dyaw, Eigen::Vector3d::UnitZ()) * Eigen::Translation3d(-middle) *
         pair.T_a_b;
}

std::vector<Start> paperStarts() {
  std::vector<Start> starts;
  for (int yaw = -2; yaw <= 2; yaw++)
    for (int x = -2; x <= 2; x++)
      for (int y = -2; y <= 2; y++)
        starts.push_back({static_cast<unsigned>(starts.size()), static_cast<double>(x),
                          static_cast<double>(y), yaw * 7.5 * M_PI / 180});
  return starts;
}

std::vector<Start> randomStarts(unsigned count, double translation, double yaw, unsigned seed) {
  std::mt19937 random(seed);  // its numbers are the standard's; a distribution's are not
  const auto within = [&](double limit) {
    return limit * (2 * (static_cast<double>(random()) / static_cast<double>(random.max())) - 1);
  };
  std::vector<Start> starts;
  for (unsigned i = 0; i < count; i++) {
    const double dx = within(translation), dy = within(translation);
    starts.push_back({i, dx, dy, within(yaw)});
  }
  return starts;
}

Start nearStart() { return {0, 0.4, 0.3, 5 * M_PI / 180}; }

PoseError errorOf(const Eigen::Isometry3d& T_a_b, const MapPair& pair) {
  const Eigen::Isometry3d delta = T_a_b * pair.T_a_b.inverse();
  return {delta.translation().norm(),
          (T_a_b * pair.centre_of_b - pair.T_a_b * pair.centre_of_b).norm(),
          std::abs(Eigen::AngleAxisd(delta.linear()).angle())};
}

std::shared_ptr<const octomap::OcTree> cropMap(const octomap::OcTree& map,
                                               const Eigen::Vector3d& direction, double offset) {
  auto part = std::make_shared<octomap::OcTree>(map.getResolution());
  mrpt::fusion::OcTreeAccess::setSensorModel(*part, mrpt::fusion::OcTreeAccess::sensorModel(map));
  CropVisitor visitor(map, direction, offset);
  mrpt::fusion::buildOcTree(*part, CropVisitor::State{map.getRoot()}, visitor);
  return part;
}

namespace {

/** A tree of the finest voxels of another: `f(tree, key, log_odds)` puts each where it belongs. */
template <class F>
std::shared_ptr<const octomap::OcTree> voxelByVoxel(const octomap::OcTree& map, F&& f) {
  auto result = std::make_shared<octomap::OcTree>(map.getResolution());
  mrpt::fusion::OcTreeAccess::setSensorModel(*result, mrpt::fusion::OcTreeAccess::sensorModel(map));
  for (auto leaf = map.begin_leafs(); leaf != map.end_leafs(); ++leaf) {
    const octomap::OcTreeKey low = leaf.getIndexKey();
    const int side = 1 << (map.getTreeDepth() - leaf.getDepth());
    for (int x = 0; x < side; x++)
      for (int y = 0; y < side; y++)
        for (int z = 0; z < side; z++)
          f(*result,
            octomap::OcTreeKey(static_cast<octomap::key_type>(low[0] + x),
                               static_cast<octomap::key_type>(low[1] + y),
                               static_cast<octomap::key_type>(low[2] + z)),
            leaf->getLogOdds());
  }
  result->updateInnerOccupancy();
  result->prune();
  return result;
}

}  // namespace

std::shared_ptr<const octomap::OcTree> mirrored(const octomap::OcTree& map) {
  return voxelByVoxel(map, [](octomap::OcTree& image, octomap::OcTreeKey key, float log_odds) {
    key[0] = static_cast<octomap::key_type>(std::numeric_limits<octomap::key_type>::max() - key[0]);
    image.setNodeValue(key, log_odds, true);
  });
}

std::shared_ptr<const octomap::OcTree> changed(
    const octomap::OcTree& map,
    const std::function<float(const octomap::OcTreeKey& key, float log_odds)>& change) {
  return voxelByVoxel(map, [&](octomap::OcTree& result, const octomap::OcTreeKey& key, float was) {
    const float log_odds = change(key, was);
    if (!std::isnan(log_odds)) result.setNodeValue(key, 0.F, true)->setLogOdds(log_odds);
  });
}

std::shared_ptr<const octomap::OcTree> resampled(const octomap::OcTree& map, double resolution) {
  return transformOcTree(map, Eigen::Isometry3d::Identity(), resolution);
}

std::shared_ptr<const octomap::OcTree> withAThirdOfObstacles(const octomap::OcTree& map) {
  const auto seen = [](const octomap::OcTreeKey& key) {
    return octomap::OcTreeKey::KeyHash()(key) * 2654435761U % 4294967296U < 4294967296U / 3;
  };
  return changed(map, [&](const auto& key, float l) { return l < 0 || seen(key) ? l : NAN; });
}

double neesOf(const Eigen::Isometry3d& T_a_b, const Eigen::Matrix<double, 6, 6>& covariance,
              const Eigen::Isometry3d& truth) {
  const Eigen::Isometry3d off = truth * T_a_b.inverse();
  const Eigen::AngleAxisd turn(off.linear());
  Eigen::Matrix<double, 6, 1> error;
  error << off.translation(), turn.angle() * turn.axis();
  return error.dot(covariance.ldlt().solve(error));
}

double trueOverlap(const MapPair& pair) {
  const OccupiedVoxels a = extractOccupiedVoxels(*pair.a), b = extractOccupiedVoxels(*pair.b);
  if (a.size() == 0 || b.size() == 0) return 0;
  const double near = std::max({0.1, a.resolution, b.resolution}) + 1e-6;
  const auto share = [&](const OccupiedVoxels& model, const OccupiedVoxels& scene,
                         const Eigen::Isometry3d& T) {
    const Pairs found = VoxelAssociation(model).associate(scene, T, {}, near);
    return static_cast<double>(found.size()) / static_cast<double>(scene.size());
  };
  return 0.5 * (share(a, b, pair.T_a_b) + share(b, a, pair.T_a_b.inverse()));
}

MapPair randomParts(const MapPair& pair, std::mt19937& generator) {
  constexpr double kLeastKept = 0.55;  // of a map's voxels
  std::uniform_real_distribution<double> heading(-M_PI, M_PI), kept(kLeastKept, 1);
  const double yaw = heading(generator);
  const Eigen::Vector3d d(std::cos(yaw), std::sin(yaw), 0);  // in A's frame
  const auto quantile = [&](const octomap::OcTree& map, const Eigen::Isometry3d& T, double share) {
    std::vector<double> along;
    for (const auto& c : extractOccupiedVoxels(map).centre)
      along.push_back(d.dot(T * c.cast<double>()));
    const auto at =
        along.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(along.size() - 1));
    std::nth_element(along.begin(), at, along.end());
    return *at;
  };
  const double end = quantile(*pair.a, Eigen::Isometry3d::Identity(), kept(generator));
  const double begin = quantile(*pair.b, pair.T_a_b, 1 - kept(generator));
  MapPair parts = pair;
  parts.a = cropMap(*pair.a, -d, -end);
  parts.b = cropMap(*pair.b, pair.T_a_b.linear().transpose() * d,
                    begin - d.dot(pair.T_a_b.translation()));
  return parts;
}

}  // namespace mrpt::fusion::benchmark
