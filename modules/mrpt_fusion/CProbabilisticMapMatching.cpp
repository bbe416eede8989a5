// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The registration class for MRPT: it calls mrpt::fusion::align() and its relatives. */

#include <mrpt/fusion/many_maps.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/poses/CPosePDFGaussian.h>
#include <mrpt/slam/CProbabilisticMapMatching.h>
#include <mrpt/system/CTicTac.h>
#include <tbb/parallel_invoke.h>

#include <cmath>
#include <optional>
#include <utility>

#include "mrpt_fusion/borrowed.h"

using namespace mrpt::slam;
using namespace mrpt::fusion;
using mrpt::maps::CMetricMap;
using mrpt::maps::CProbOctoMap;
using mrpt::poses::CPose3D;

CProbabilisticMapMatching::CProbabilisticMapMatching() {
  setLoggerName("CProbabilisticMapMatching");
}

namespace {

/** Returns the octomap of a map of MRPT. \exception std::exception If there is none. */
std::shared_ptr<const CProbOctoMap> wholeMapOf(const CMetricMap& map) {
  auto octomap = asProbOctoMap(map);
  ASSERTMSG_(octomap, std::string("a ") + map.GetRuntimeClass()->className +
                          " is not, and holds no, 3-D occupancy map");
  return octomap;
}

/** Prepares both maps in parallel. */
std::pair<PreparedMap, PreparedMap> prepareBoth(const CMetricMap& m1, const CMetricMap& m2,
                                                const FeatureParams& params) {
  std::optional<PreparedMap> a, b;
  tbb::parallel_invoke([&] { a.emplace(prepareBorrowed(m1, params)); },
                       [&] { b.emplace(prepareBorrowed(m2, params)); });
  return {*a, *b};
}

}  // namespace

EdgeVoxels CProbabilisticMapMatching::edges(const CMetricMap& map) const {
  const mrpt::system::CTimeLoggerEntry timing(profiler, "edges");
  return extractEdges(extractOccupiedVoxels(wholeMapOf(map)->octree()), options.features.edges);
}

mrpt::poses::CPose3DPDF::Ptr CProbabilisticMapMatching::Align3DPDF(
    const CMetricMap* m1, const CMetricMap* m2,
    const mrpt::poses::CPose3DPDFGaussian& initialEstimationPDF,
    mrpt::optional_ref<TMetricMapAlignmentResult> outInfo) {
  ASSERTMSG_(m1 && m2, "CProbabilisticMapMatching: a map is null");
  mrpt::system::CTicTac clock;
  const auto [a, b] = prepareBoth(*m1, *m2, options.features);
  const double seconds_features = clock.Tac();
  Alignment found = align(a, b, Prior::gaussian(initialEstimationPDF), options, onIteration);
  constexpr bool kIsTime = true;
  profiler.registerUserMeasure("features", seconds_features, kIsTime);
  profiler.registerUserMeasure("match", found.seconds_matching, kIsTime);
  profiler.registerUserMeasure("evaluate", found.seconds_evaluation, kIsTime);
  MRPT_LOG_DEBUG_FMT("%zu iterations, %zu pairs, %s", found.match.iterations.size(),
                     found.match.pairs.size(), found.evaluation.accepted ? "accepted" : "rejected");

  const auto pdf = std::make_shared<mrpt::poses::CPose3DPDFGaussian>(found.pose());
  if (outInfo) {
    TMetricMapAlignmentResult& wanted = outInfo.value().get();
    wanted.executionTime = seconds_features + found.seconds_matching + found.seconds_evaluation;
    if (auto* all = dynamic_cast<TReturnInfo*>(&wanted)) {
      static_cast<Alignment&>(*all) = std::move(found);
      all->seconds_features = seconds_features;
    }
  }
  return pdf;
}

mrpt::poses::CPosePDF::Ptr CProbabilisticMapMatching::AlignPDF(
    const CMetricMap* m1, const CMetricMap* m2,
    const mrpt::poses::CPosePDFGaussian& initialEstimationPDF,
    mrpt::optional_ref<TMetricMapAlignmentResult> outInfo) {
  mrpt::poses::CPose3DPDFGaussian prior(initialEstimationPDF);
  if (!prior.cov.asEigen().isZero(0))  // the height is unknown
    prior.cov(2, 2) = std::pow(options.search.height / kSearchSigmas, 2);
  const auto pdf = Align3DPDF(m1, m2, prior, outInfo);
  auto plane = std::make_shared<mrpt::poses::CPosePDFGaussian>();
  plane->copyFrom(*pdf);
  return plane;
}

CProbabilisticMapMatching::TReturnInfo CProbabilisticMapMatching::evaluate(
    const CMetricMap& m1, const CMetricMap& m2, const CPose3D& pose) const {
  const mrpt::system::CTimeLoggerEntry timing(profiler, "evaluate");
  mrpt::system::CTicTac clock;
  const auto [a, b] = prepareBoth(m1, m2, options.features);
  TReturnInfo info;
  info.seconds_features = clock.Tac();
  static_cast<Alignment&>(info) = mrpt::fusion::evaluate(a, b, pose, options);
  info.executionTime = clock.Tac();
  return info;
}

CProbOctoMap CProbabilisticMapMatching::merge(const CMetricMap& m1, const CMetricMap& m2,
                                              const CPose3D& pose) const {
  const mrpt::system::CTimeLoggerEntry timing(profiler, "merge");
  const auto a = wholeMapOf(m1), b = wholeMapOf(m2);
  constexpr bool kIsGiven = true;
  auto merged = mergeSources({a->octree(), a->sources()}, {b->octree(), b->sources()},
                             toEigen(pose), options.merge, kIsGiven);
  CProbOctoMap map(std::move(merged.map));
  map.setSources(std::move(merged.sources));
  return map;
}
