// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * CProbOctoMap: the occupied voxels as points, and the matching of these points. */

#include <mrpt/fusion/voxels.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "fusion_octree/walk.h"

using namespace mrpt::fusion;
using namespace mrpt::maps;

namespace {

/** Returns the centres of the occupied voxels, in the order of the octree. */
std::shared_ptr<CSimplePointsMap> occupiedPoints(const octomap::OcTree& tree) {
  auto points = std::make_shared<CSimplePointsMap>();
  const mrpt::fusion::OccupiedVoxels voxels = mrpt::fusion::extractOccupiedVoxels(tree);
  points->reserve(voxels.size());
  for (const auto& p : voxels.centre) points->insertPointFast(p.x(), p.y(), p.z());
  points->mark_as_modified();  // insertPointFast() does not do this
  return points;
}

bool samePoints(const CPointsMap& a, const CPointsMap& b) {
  return a.getPointsBufferRef_x() == b.getPointsBufferRef_x() &&
         a.getPointsBufferRef_y() == b.getPointsBufferRef_y() &&
         a.getPointsBufferRef_z() == b.getPointsBufferRef_z();
}

/** Returns the points of the other map of a matching. */
std::shared_ptr<const CPointsMap> pointsOf(const CMetricMap* map) {
  ASSERTMSG_(map, "CProbOctoMap: there is no map to match with");
  if (const auto* points = dynamic_cast<const CPointsMap*>(map))
    return {std::shared_ptr<const CPointsMap>(), points};  // not owned
  if (const CPointsMap* points = map->getAsSimplePointsMap())
    return {std::shared_ptr<const CPointsMap>(), points};
  const auto octomap = asProbOctoMap(*map);
  ASSERTMSG_(octomap, std::string("CProbOctoMap: a ") + map->GetRuntimeClass()->className +
                          " has no points to match with");
  return occupiedPoints(octomap->octree());
}

/** Finds the smallest square distance in the plane from a point to the centre of an occupied voxel,
 * by branch and bound. */
class ClosestInPlane {
 public:
  ClosestInPlane(const octomap::OcTree& tree, double x, double y) : tree_(tree), xy_{x, y} {
    if (tree.getRoot()) descend(*tree.getRoot(), {});
  }
  /** The square distance, m^2. Infinite if no voxel is occupied. */
  double squareDistance() const { return best_; }

 private:
  /** Returns the square distance to the closest centre of the voxels of a cube, m^2. */
  double squareDistanceTo(const OcTreeCube& cube) const {
    double sum = 0;
    for (unsigned axis = 0; axis < 2; axis++) {
      const auto centre = [&](uint32_t k) {
        return tree_.keyToCoord(static_cast<octomap::key_type>(k));
      };
      const double first = centre(cube.key[axis]), last = centre(cube.key[axis] + cube.side() - 1);
      const double steps = std::round((xy_[axis] - first) / tree_.getResolution());
      const double closest = std::clamp(first + steps * tree_.getResolution(), first, last);
      sum += (xy_[axis] - closest) * (xy_[axis] - closest);
    }
    return sum;
  }

  void descend(const octomap::OcTreeNode& node, const OcTreeCube& cube) {
    if (squareDistanceTo(cube) >= best_) return;
    if (!tree_.nodeHasChildren(&node)) {
      if (tree_.isNodeOccupied(node)) best_ = squareDistanceTo(cube);
      return;
    }
    // The child on the side of the point comes first, so that the bound becomes tight early.
    const auto middle = cube.child(7).key;
    unsigned near = 0;
    for (unsigned axis = 0; axis < 2; axis++)
      if (xy_[axis] > tree_.keyToCoord(middle[axis]) - 0.5 * tree_.getResolution())
        near |= 1U << axis;
    for (unsigned i = 0; i < 8; i++)
      if (tree_.nodeChildExists(&node, near ^ i))
        descend(*tree_.getNodeChild(&node, near ^ i), cube.child(near ^ i));
  }

  const octomap::OcTree& tree_;
  std::array<double, 2> xy_;
  double best_ = std::numeric_limits<double>::infinity();
};

}  // namespace

const CSimplePointsMap* CProbOctoMap::getAsSimplePointsMap() const {
  // The tree may have changed through octree(), so the points are always made anew. If they are
  // equal to the previous points, the previous points stay, because a caller may still use them.
  const std::shared_ptr<const CSimplePointsMap> now = occupiedPoints(*m_octree);
  now->boundingBox();  // the first call computes the box; two threads must not do this at once
  auto last = std::atomic_load(&m_points);
  while (!last || !samePoints(*last, *now))
    if (std::atomic_compare_exchange_strong(&m_points, &last, now)) return now.get();
  return last.get();
}

void CProbOctoMap::auxParticleFilterCleanUp() {
  std::atomic_store(&m_points, std::shared_ptr<const CSimplePointsMap>());
}

namespace {

/** Returns the points of a map for one matching. A point map of MRPT has one k-d tree, which is for
 * 2-D or for 3-D searches. So each matching gets its own points. */
std::shared_ptr<CSimplePointsMap> pointsToMatch(const octomap::OcTree& tree) {
  auto points = occupiedPoints(tree);
  // MRPT finds no pairs if the bounding boxes of both maps do not overlap, even if points are
  // within reach, for example in a flat scan just below a layer of voxel centres. These two points
  // are out of reach of all others, and their box overlaps every box.
  constexpr float kFar = 1e6F;
  for (const float corner : {-kFar, kFar}) points->insertPoint(corner, corner, corner);
  return points;
}

}  // namespace

void CProbOctoMap::determineMatching2D(const CMetricMap* otherMap,
                                       const mrpt::poses::CPose2D& otherMapPose,
                                       mrpt::tfest::TMatchingPairList& correspondences,
                                       const TMatchingParams& params,
                                       TMatchingExtraResults& extraResults) const {
  pointsToMatch(*m_octree)->determineMatching2D(pointsOf(otherMap).get(), otherMapPose,
                                                correspondences, params, extraResults);
}

void CProbOctoMap::determineMatching3D(const CMetricMap* otherMap,
                                       const mrpt::poses::CPose3D& otherMapPose,
                                       mrpt::tfest::TMatchingPairList& correspondences,
                                       const TMatchingParams& params,
                                       TMatchingExtraResults& extraResults) const {
  pointsToMatch(*m_octree)->determineMatching3D(pointsOf(otherMap).get(), otherMapPose,
                                                correspondences, params, extraResults);
}

float CProbOctoMap::compute3DMatchingRatio(const CMetricMap* otherMap,
                                           const mrpt::poses::CPose3D& otherMapPose,
                                           const TMatchingRatioParams& params) const {
  TMatchingParams matching;
  matching.maxDistForCorrespondence = params.maxDistForCorr;
  mrpt::tfest::TMatchingPairList pairs;
  TMatchingExtraResults results;
  determineMatching3D(otherMap, otherMapPose, pairs, matching, results);
  return results.correspondencesRatio;
}

float CProbOctoMap::squareDistanceToClosestCorrespondence(float x0, float y0) const {
  const double d2 = ClosestInPlane(*m_octree, x0, y0).squareDistance();
  ASSERTMSG_(std::isfinite(d2), "CProbOctoMap: the map has no occupied voxel to measure to");
  return static_cast<float>(d2);
}
