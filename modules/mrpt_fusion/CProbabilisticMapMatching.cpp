// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/map_files.h>
#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/poses/CPosePDFGaussian.h>
#include <mrpt/slam/CProbabilisticMapMatching.h>

#include <cmath>
#include <utility>

using namespace mrpt::slam;
using namespace mrpt::fusion;
using mrpt::maps::CEdgeVoxelMap;
using mrpt::maps::CMetricMap;
using mrpt::maps::CProbOctoMap;
using mrpt::poses::CPose3D;

MatchableMap mrpt::fusion::matchable(const CMetricMap& map) {
  if (const auto* edges = dynamic_cast<const CEdgeVoxelMap*>(&map))
    return {nullptr, {nullptr, &edges->edges()}};
  auto octomap = mrpt::fusion::asProbOctoMap(map);
  ASSERTMSG_(octomap, std::string("a ") + map.GetRuntimeClass()->className +
                          " is not, and holds no, 3-D occupancy map");
  const octomap::OcTree* octree = &octomap->octree();
  return {std::move(octomap), {octree, nullptr}};
}

CProbabilisticMapMatching::CProbabilisticMapMatching() {
  setLoggerName("CProbabilisticMapMatching");
}

EdgeVoxels CProbabilisticMapMatching::edges(const CMetricMap& map) const {
  const mrpt::system::CTimeLoggerEntry timing(profiler, "edges");
  const MatchableMap m = matchable(map);
  return extractEdges(extractOccupiedVoxels(m.view.wholeMap()), options.match.edges);
}

mrpt::poses::CPose3DPDF::Ptr CProbabilisticMapMatching::Align3DPDF(
    const CMetricMap* m1, const CMetricMap* m2,
    const mrpt::poses::CPose3DPDFGaussian& initialEstimationPDF,
    mrpt::optional_ref<TMetricMapAlignmentResult> outInfo) {
  ASSERTMSG_(m1 && m2, "CProbabilisticMapMatching: a map is null");
  const MatchableMap a = matchable(*m1), b = matchable(*m2);
  Alignment found = align(a.view, b.view, initialEstimationPDF, options, onIteration);
  constexpr bool kIsTime = true;
  profiler.registerUserMeasure("features", found.seconds_features, kIsTime);
  profiler.registerUserMeasure("match", found.seconds_matching, kIsTime);
  profiler.registerUserMeasure("evaluate", found.seconds_evaluation, kIsTime);
  MRPT_LOG_DEBUG_FMT("%u iterations, %zu pairs, %s", found.nIterations, found.match.pairs.size(),
                     found.evaluation.accepted ? "accepted" : "rejected");

  const auto pdf = std::make_shared<mrpt::poses::CPose3DPDFGaussian>(found.pose);
  if (outInfo) {
    TMetricMapAlignmentResult& wanted = outInfo.value().get();
    wanted.executionTime =
        found.seconds_features + found.seconds_matching + found.seconds_evaluation;
    if (auto* all = dynamic_cast<TReturnInfo*>(&wanted))
      static_cast<Alignment&>(*all) = std::move(found);
  }
  return pdf;
}

mrpt::poses::CPosePDF::Ptr CProbabilisticMapMatching::AlignPDF(
    const CMetricMap* m1, const CMetricMap* m2,
    const mrpt::poses::CPosePDFGaussian& initialEstimationPDF,
    mrpt::optional_ref<TMetricMapAlignmentResult> outInfo) {
  mrpt::poses::CPose3DPDFGaussian prior(initialEstimationPDF);
  if (!prior.cov.asEigen().isZero(0))  // a pose in the plane says nothing of the height
    prior.cov(2, 2) = std::pow(options.match.search.height / kSearchSigmas, 2);
  const auto pdf = Align3DPDF(m1, m2, prior, outInfo);
  auto plane = std::make_shared<mrpt::poses::CPosePDFGaussian>();
  plane->copyFrom(*pdf);
  return plane;
}

CProbabilisticMapMatching::TReturnInfo CProbabilisticMapMatching::evaluate(
    const CMetricMap& m1, const CMetricMap& m2, const CPose3D& pose) const {
  const MatchableMap a = matchable(m1), b = matchable(m2);
  const mrpt::system::CTimeLoggerEntry timing(profiler, "evaluate");
  TReturnInfo info;
  static_cast<Alignment&>(info) = mrpt::fusion::evaluate(a.view, b.view, pose, options);
  info.executionTime = info.seconds_evaluation;
  return info;
}

CProbOctoMap CProbabilisticMapMatching::merge(const CMetricMap& m1, const CMetricMap& m2,
                                              const CPose3D& pose) const {
  const MatchableMap a = matchable(m1), b = matchable(m2);
  const mrpt::system::CTimeLoggerEntry timing(profiler, "merge");
  return CProbOctoMap(
      mergeMaps(a.view.wholeMap(), b.view.wholeMap(), toEigen(pose), options.merge));
}
