// SPDX-License-Identifier: BSD-3-Clause
#include "truth.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "fusion_octree/build.h"
#include "fusion_octree/resampling.h"

namespace mrpt::fusion::benchmark {
namespace {

using mrpt::fusion::childOrSelf;
using Node = const octomap::OcTreeNode*;

class LabelVisitor {
 public:
  struct State {
    Node known, world;
  };

  LabelVisitor(const octomap::OcTree& known, const octomap::OcTree& world)
      : known_(known), world_(world) {}

  mrpt::fusion::OcTreeFill visit(const mrpt::fusion::OcTreeCube&, const State& s) const {
    using mrpt::fusion::OcTreeFill;
    if (!s.known) return OcTreeFill::unknown();
    if (known_.nodeHasChildren(s.known) || (s.world && world_.nodeHasChildren(s.world)))
      return OcTreeFill::split();
    const bool occupied = s.world && world_.isNodeOccupied(s.world);
    return OcTreeFill::leaf(occupied ? known_.getClampingThresMaxLog()
                                     : known_.getClampingThresMinLog());
  }
  State descend(const State& s, unsigned i, const mrpt::fusion::OcTreeCube&) const {
    return {childOrSelf(known_, s.known, i), childOrSelf(world_, s.world, i)};
  }

 private:
  const octomap::OcTree& known_;
  const octomap::OcTree& world_;
};

/** Walks truth and map side by side and adds up. */
class Comparison {
 public:
  Comparison(const octomap::OcTree& truth, const octomap::OcTree& map) : truth_(truth), map_(map) {
    walk(truth.getRoot(), map.getRoot(), 0);
  }

  TruthComparison result() const {
    return {log_loss_ / voxels_, brier_ / voxels_, 2 * both_ / (in_truth_ + in_map_)};
  }

 private:
  void walk(Node truth, Node map, unsigned depth) {
    if (!truth) return;
    if (!truth_.nodeHasChildren(truth) && !(map && map_.nodeHasChildren(map)))
      return add(truth, map, depth);
    for (unsigned i = 0; i < 8; i++)
      walk(childOrSelf(truth_, truth, i), childOrSelf(map_, map, i), depth + 1);
  }

  void add(Node truth, Node map, unsigned depth) {
    const double volume = std::pow(8.0, mrpt::fusion::OcTreeCube::kMaxDepth - depth);
    const bool occupied = truth_.isNodeOccupied(truth);
    const bool found = map && map_.isNodeOccupied(map);
    const double p = map ? std::clamp(map->getOccupancy(), 1e-6, 1 - 1e-6) : 0.5;
    const double error = (occupied ? 1.0 : 0.0) - p;
    voxels_ += volume;
    log_loss_ -= volume * std::log(occupied ? p : 1 - p);
    brier_ += volume * error * error;
    if (occupied) in_truth_ += volume;
    if (found) in_map_ += volume;
    if (occupied && found) both_ += volume;
  }

  const octomap::OcTree& truth_;
  const octomap::OcTree& map_;
  double voxels_ = 0, log_loss_ = 0, brier_ = 0, in_truth_ = 0, in_map_ = 0, both_ = 0;
};

}  // namespace

bool hasTruth(const MapPair& pair) {
  return std::filesystem::exists(pair.folder + "/reference.ot");
}

Truth loadTruth(const MapPair& pair) {
  Truth truth;
  if (!hasTruth(pair)) return truth;
  truth.reference = loadTree(pair.folder + "/reference.ot");
  const auto world =
      mrpt::fusion::transformOcTree(*loadTree(pair.folder + "/world.bt"),
                                    loadPose(pair.folder + "/T_a_w.txt"), pair.a->getResolution());
  truth.building = labelled(*truth.reference, *world);
  return truth;
}

std::shared_ptr<const octomap::OcTree> labelled(const octomap::OcTree& known,
                                                const octomap::OcTree& world) {
  auto labels = std::make_shared<octomap::OcTree>(known.getResolution());
  LabelVisitor visitor(known, world);
  mrpt::fusion::buildOcTree(*labels, LabelVisitor::State{known.getRoot(), world.getRoot()},
                            visitor);
  return labels;
}

TruthComparison compareWithTruth(const octomap::OcTree& truth, const octomap::OcTree& map) {
  return Comparison(truth, map).result();
}

}  // namespace mrpt::fusion::benchmark
