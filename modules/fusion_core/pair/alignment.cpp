// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/core/exceptions.h>
#include <mrpt/fusion/alignment.h>
#include <mrpt/fusion/edge_octree.h>
#include <mrpt/fusion/poses.h>
#include <mrpt/system/CTicTac.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace mrpt::fusion {
namespace {

/** A map to match by its edges, and the octrees that its features point to. */
class EdgeMap {
 public:
  EdgeMap(const MapView& map, const EdgeParams& params)
      : edges_(map.edges ? *map.edges : extractEdges(extractOccupiedVoxels(*map.octree), params)),
        edge_tree_(occupancyTree(edges_)),
        octree_(map.octree ? *map.octree : edge_tree_) {}

  MapFeatures features() const { return featuresOfEdges(octree_, edge_tree_, edges_); }

 private:
  EdgeVoxels edges_;
  octomap::OcTree edge_tree_;
  const octomap::OcTree& octree_;
};

double secondsSince(mrpt::system::CTicTac& clock) {
  const double s = clock.Tac();
  clock.Tic();
  return s;
}

mrpt::poses::CPose3DPDFGaussian gaussian(const Eigen::Isometry3d& T, const Matrix6d& covariance) {
  return {toPose(T), mrpt::math::CMatrixDouble66(toYawPitchRollCovariance(covariance, T))};
}

mrpt::poses::CPose3DPDFSOG modesOf(std::vector<RankedPose> possible) {
  // No weight can be zero.
  while (!possible.empty() && possible.back().agreement <= 0) possible.pop_back();
  mrpt::poses::CPose3DPDFSOG modes(possible.size());
  std::transform(possible.begin(), possible.end(), modes.begin(), [](const RankedPose& h) {
    mrpt::poses::CPose3DPDFSOG::TGaussianMode mode;
    mode.val = gaussian(h.T_a_b, h.covariance);
    mode.log_w = std::log(h.agreement);
    return mode;
  });
  return modes;
}

}  // namespace

const octomap::OcTree& MapView::wholeMap() const {
  ASSERTMSG_(octree, "the edges of a map are not, and hold no, 3-D occupancy map");
  return *octree;
}

Alignment align(const MapView& m1, const MapView& m2, const mrpt::poses::CPose3DPDFGaussian& prior,
                const Options& options, const OnIteration& on_iteration) {
  const Eigen::Isometry3d guess = toEigen(prior.mean);
  ASSERTMSG_(guess.matrix().allFinite(), "the initial guess is not a pose");
  mrpt::system::CTicTac clock;
  Alignment result;
  result.by_edges = m1.edges || m2.edges;
  std::optional<EdgeMap> edges_1, edges_2;
  if (result.by_edges) {
    edges_1.emplace(m1, options.match.edges);
    edges_2.emplace(m2, options.match.edges);
  }
  const auto [a, b] = result.by_edges ? std::pair(edges_1->features(), edges_2->features())
                                      : computeFeatures(*m1.octree, *m2.octree, options.match);
  ASSERTMSG_(a.voxels.size() > 0, "map m1 has no occupied voxel");
  ASSERTMSG_(b.voxels.size() > 0, "map m2 has no occupied voxel");
  result.voxels_m1 = a.voxels.size();
  result.voxels_m2 = b.voxels.size();
  result.edges_m1 = a.edges.size();
  result.edges_m2 = b.edges.size();
  result.seconds_features = secondsSince(clock);

  MatchParams params = options.match;
  params.search = searchWithin(prior, options.match.search);
  result.match = matchMaps(a, b, guess, params, on_iteration);
  result.nIterations = static_cast<unsigned>(result.match.iterations.size());
  result.seconds_matching = secondsSince(clock);

  result.evaluation = judgeMatch(a, b, params, options.evaluation, result.match);
  if (result.by_edges) {
    result.evaluation.accepted = result.evaluation.is_ambiguous = false;
    result.evaluation.reasons.emplace_back(
        "edges alone tell where the maps meet, not that they may be merged");
  }
  result.seconds_evaluation = secondsSince(clock);
  result.pose = gaussian(result.match.T_a_b, result.match.covariance);
  result.hypotheses = modesOf(result.match.hypotheses);
  return result;
}

Alignment evaluate(const MapView& m1, const MapView& m2, const mrpt::poses::CPose3D& pose,
                   const Options& options) {
  mrpt::system::CTicTac clock;
  const auto [a, b] = computeFeatures(m1.wholeMap(), m2.wholeMap(), options.match);
  Alignment result;
  result.voxels_m1 = a.voxels.size();
  result.voxels_m2 = b.voxels.size();
  result.edges_m1 = a.edges.size();
  result.edges_m2 = b.edges.size();
  result.match.T_a_b = toEigen(pose);
  result.match.pairs = pairVoxels(a, b, result.match.T_a_b, options.match);
  result.evaluation = judgeMatch(a, b, options.match, options.evaluation, result.match);
  result.pose = gaussian(result.match.T_a_b, result.match.covariance);
  result.pose.mean = pose;  // to the last bit
  result.seconds_evaluation = secondsSince(clock);
  return result;
}

}  // namespace mrpt::fusion
