// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Loads, matches, merges and draws two maps. */

#include "map_pair.h"

#include <mrpt/fusion/alignment.h>
#include <mrpt/fusion/edges.h>
#include <mrpt/fusion/many_maps.h>
#include <mrpt/fusion/poses.h>
#include <mrpt/fusion/voxels.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_group.h>

#include <iostream>
#include <optional>
#include <utility>
#include <vector>

#include "fusion_base/error_text.h"
#include "fusion_base/printable.h"
#include "fusion_report/top_view.h"
#include "inputs.h"
#include "joined_recordings.h"
#include "output.h"
#include "pages.h"
#include "pose.h"
#include "priors.h"

using mrpt::fusion::EdgeVoxels;
using mrpt::fusion::PreparedMap;
using mrpt::fusion::toEigen;

namespace map_fusion {

namespace {

/** Returns what the arguments say about the pose of B in A. */
mrpt::fusion::Prior priorOf(const RunContext& run, const MapPair& pair) {
  using mrpt::fusion::Prior;
  const auto& sigma = run.args.init_sigma;
  if (pair.prior) return *pair.prior;
  if (!run.report.initial_pose) return Prior::none();
  const auto& guess = *run.report.initial_pose;
  return sigma.empty() ? Prior::near(guess)
                       : Prior::within(guess, sigma[0], mrpt::DEG2RAD(sigma[1]));
}

/** True if a rejected match without a guess would be accepted with --full-6dof. Cameras look along
 * z, and some frames point down. */
bool fitsWithoutCommonVertical(const RunContext& run, const PreparedMap& a, const PreparedMap& b) {
  using mrpt::fusion::SearchRotations;
  mrpt::fusion::Options options = run.options;
  const bool is_asked = run.report.initial_pose || !run.args.priors.empty() ||
                        options.search.translation <= 0 ||
                        options.search.rotations == SearchRotations::All;
  if (is_asked || run.report.match->by_edges || run.report.match->evaluation.accepted) return false;
  options.search.rotations = SearchRotations::All;
  return mrpt::fusion::align(a, b, mrpt::fusion::Prior::none(), options).evaluation.accepted;
}

void drawPicture(RunContext& run, const MapPair& pair) {
  std::vector<mrpt::fusion::TopViewPanel> panels;
  if (run.report.initial_pose)
    panels.push_back({"initial guess", toEigen(*run.report.initial_pose)});
  const auto& match = run.report.match;
  panels.push_back({!match                       ? "at the given pose"
                    : match->evaluation.accepted ? "result: accepted"
                                                 : "result: rejected",
                    toEigen(run.report.pose->mean)});
  const auto picture = drawTopView(mrpt::fusion::extractOccupiedVoxels(*pair.a.octree),
                                   mrpt::fusion::extractOccupiedVoxels(*pair.b.octree), panels);
  run.write(run.args.picture, picture.toPng());
  run.endStep("picture");
}

void drawScene(RunContext& run, const MapPair& pair) {
  run.progress.show("drawing");
  const EdgeVoxels edges_a = pair.a.edges ? *pair.a.edges : edgesOf(run, pair.a);
  const EdgeVoxels edges_b = pair.b.edges ? *pair.b.edges : edgesOf(run, pair.b);
  const mrpt::fusion::Pairs none;
  const SceneContents contents{*pair.a.octree,
                               *pair.b.octree,
                               run.report.pose->mean,
                               run.report.match ? run.report.match->match.pairs : none,
                               edges_a,
                               edges_b,
                               run.options.evaluation.inlier_mahalanobis,
                               pair.fused.get()};
  mrptMaps().drawScene(contents, run.args.scene);
  run.wrote(run.args.scene);
  run.progress.clear();
  run.endStep("scene");
}

}  // namespace

MapPair loadPair(RunContext& run) {
  checkRecordings(run);
  if (!run.args.init.empty()) run.report.initial_pose = parsePose(run.args.init);
  if (!run.args.pose.empty()) run.report.pose.emplace().mean = parsePose(run.args.pose);
  MapPair pair;
  const auto& paths = run.args.maps;
  if (!run.args.priors.empty()) pair.prior = loadPriors(run.args.priors, paths.size()).of(0, 1);
  std::optional<ReadOctree> a, b;
  tbb::parallel_invoke([&] { a = readAhead(run, "a", paths[0]); },
                       [&] { b = readAhead(run, "b", paths[1]); });
  pair.a = loadMap(run, "a", paths[0], std::move(a));
  pair.b = loadMap(run, "b", paths[1], std::move(b));
  return pair;
}

void preparePair(const RunContext& run, MapPair& pair) {
  std::optional<PreparedMap> a, b;
  const auto prepare = [&](size_t i, const LoadedMap& map, std::optional<PreparedMap>& prepared) {
    mrpt::fusion::withPath(run.args.maps[i],
                           [&] { prepared.emplace(map.prepared(run.options.features)); });
  };
  tbb::parallel_invoke([&] { prepare(0, pair.a, a); }, [&] { prepare(1, pair.b, b); });
  pair.prepared.emplace(*a, *b);
}

bool matchPair(RunContext& run, MapPair& pair) {
  run.progress.show("extracting edges");
  preparePair(run, pair);
  const auto& [a, b] = *pair.prepared;
  run.endStep("features");
  run.report.match = mrpt::fusion::align(a, b, priorOf(run, pair), run.options, run.on_iteration);
  if (fitsWithoutCommonVertical(run, a, b))
    run.report.match->evaluation.addReasonAgainst(
        "the maps fit if up is another direction in map B: pass --full-6dof");
  run.progress.clear();
  const auto& match = *run.report.match;
  run.report.pose = match.pose();
  run.report.seconds.emplace_back("match", match.seconds_matching);
  run.report.seconds.emplace_back("evaluate", match.seconds_evaluation);
  run.startStep();
  if (!run.args.pose_out.empty()) run.write(run.args.pose_out, toMatrixText(run.report.pose->mean));
  return match.evaluation.accepted;
}

void tellRejection(const RunContext& run, const std::string& consequence) {
  const auto& e = run.report.match->evaluation;
  std::cerr << "map-fusion: the match is " << (e.is_ambiguous ? "ambiguous" : "rejected")
            << (e.reasons.empty() ? "" : ": " + mrpt::fusion::printable(e.reasons.front()))
            << consequence << "\n";
}

bool concludeMatch(const RunContext& run) {
  const bool accepted = run.report.match->evaluation.accepted;
  if (!accepted && run.args.quiet) tellRejection(run);
  return accepted;
}

void mergePair(RunContext& run, MapPair& pair) {
  run.progress.show("merging");
  choosePolicy(run);
  const bool is_given = !run.args.pose.empty();
  auto merged = mrpt::fusion::withPath(run.args.maps[1], [&] {
    return mrpt::fusion::mergeSources({pair.a.wholeMap(), pair.a.sources},
                                      {pair.b.wholeMap(), pair.b.sources},
                                      toEigen(run.report.pose->mean), run.options.merge, is_given);
  });
  pair.fused = std::move(merged.map);
  run.progress.clear();
  run.report.counting = {merged.of_a, merged.of_b};
  noteCounting(run, run.args.maps[0], merged.of_a, run.args.maps[1]);
  noteCounting(run, run.args.maps[1], merged.of_b, run.args.maps[0]);
  run.endStep("merge");
  saveFused(run, pair.fused, merged.sources);
}

void drawPair(RunContext& run, const MapPair& pair) {
  if (!run.args.picture.empty()) drawPicture(run, pair);
  if (!run.args.scene.empty()) drawScene(run, pair);
  drawPage(run, pair);
}

void choosePolicy(RunContext& run) {
  run.options.merge.independent = run.args.independent;
  for (const auto& [policy, name] : mrpt::fusion::mergePolicyNames())
    if (run.args.policy == name) run.options.merge.policy = policy;
  for (const auto& [policy, name] : mrpt::fusion::mergePolicyNames())
    if (run.options.merge.policy == policy) run.report.policy = name;
}

void noteCounting(RunContext& run, const std::string& map, mrpt::fusion::Counting counting,
                  const std::string& with) {
  using mrpt::fusion::Counting;
  switch (counting) {
    case Counting::All:
      return;
    case Counting::UnknownSpace:
      return run.note(map + ": some of its sources are in " + with +
                      ": it adds only space that other maps do not know (--independent adds all)");
    case Counting::None:
      return run.note(map + ": all of its sources are in " + with +
                      ": nothing is added (--independent adds all)");
    case Counting::Copy:
      return run.note(map + ": has the same voxels as " + with +
                      ": both are one source and count once (--independent counts both)");
  }
}

void saveFused(RunContext& run, const std::shared_ptr<const octomap::OcTree>& fused,
               const mrpt::fusion::Sources& sources) {
  mrpt::fusion::MapReport report;
  tbb::task_group reporting;
  reporting.run([&] { report = mrpt::fusion::reportOn("fused", run.args.output, *fused); });
  try {
    if (writesRecording(run.args))
      joinRecordings(run);
    else
      saveMap(fused, run.args.output, sources);
  } catch (...) {
    reporting.wait();
    throw;
  }
  reporting.wait();
  run.wrote(run.args.output);
  run.endStep("save");
  run.report.maps.push_back(std::move(report));
  run.report.maps.back().sources = sources;
}

}  // namespace map_fusion
