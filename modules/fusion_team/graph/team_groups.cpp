// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Divides a team into the maps that hold together with the first map, and other groups. */
#include "fusion_team/graph/team_groups.h"

#include <algorithm>
#include <utility>

#include "fusion_team/graph/configuration.h"
#include "fusion_team/graph/team_search.h"

namespace mrpt::fusion {
namespace {

/** Configurations that the search grows, for each map and in all. */
constexpr size_t kStartsPerMap = 3, kMostStarts = 24;

/** Returns the placed maps that contribute least to the score, of the maps that nothing connects
 * with the first map: an eighth of them, at least one if there is one. */
std::vector<size_t> weakestOf(const TeamSearchResult& found, const std::vector<PlacedMap>& maps,
                              const TeamEvidence& evidence) {
  constexpr size_t kShare = 8;
  std::vector<std::pair<double, size_t>> order;  // by the score of the other maps
  for (size_t k = 0; k < maps.size(); k++) {
    if (k == found.first || maps[k].confirmed || !found.best.pose[k]) continue;
    order.emplace_back(-without(found.best, {k}, evidence).score, k);
  }
  std::sort(order.begin(), order.end());
  std::vector<size_t> weakest;
  for (size_t i = 0; i * kShare < order.size(); i++) weakest.push_back(order[i].second);
  return weakest;
}

/** Places maps in the frame of one of them. \param[in] maps True for the maps to place. */
std::vector<PlacedMap> placeFrom(size_t first, std::vector<bool> maps, std::vector<JudgedWay>& ways,
                                 const TeamEvidence& evidence,
                                 const std::vector<std::string>& names,
                                 const JointVerdictParams& params, const FurtherWays& further) {
  std::vector<PlacedMap> result(maps.size());
  const auto presentWays = [&] {
    std::vector<Way> present;
    for (const JudgedWay& w : ways)
      if (maps[w.way.a] && maps[w.way.b]) present.push_back(w.way);
    return present;
  };
  const auto n = static_cast<size_t>(std::count(maps.begin(), maps.end(), true));
  TeamSearchResult found =
      searchTeam(presentWays(), evidence, std::min(kMostStarts, kStartsPerMap * n), first);
  if (further) {
    const std::vector<JudgedWay> more = further(found.best);
    ways.insert(ways.end(), more.begin(), more.end());
    if (!more.empty()) found = searchAgain(found, presentWays(), evidence);
  }
  while (true) {
    const std::vector<PlacedMap> judged = judgeTeam(found, ways, evidence, names, params);
    for (size_t k = 0; k < maps.size(); k++)
      if (maps[k]) result[k] = judged[k];
    const std::vector<size_t> weakest = weakestOf(found, judged, evidence);
    if (weakest.empty()) return result;
    for (const size_t k : weakest) maps[k] = false;
    found = searchAgain(found, presentWays(), evidence, weakest);
  }
}

}  // namespace

PlacedGroups placeGroups(std::vector<JudgedWay> ways, const TeamEvidence& evidence,
                         const std::vector<std::string>& names, const JointVerdictParams& params,
                         const FurtherWays& further) {
  const size_t n = evidence.size();
  std::vector<bool> open(n, true);
  PlacedGroups result{placeFrom(0, open, ways, evidence, names, params, further), {}};
  result.others.resize(n);
  for (size_t k = 0; k < n; k++) open[k] = !result.maps[k].placed;
  for (size_t first = 0; first < n; first++) {
    if (!open[first]) continue;
    const auto placed = placeFrom(first, open, ways, evidence, names, params, further);
    std::vector<size_t> group;
    for (size_t k = 0; k < n; k++)
      if (open[k] && placed[k].placed) group.push_back(k);
    for (const size_t k : group) {
      open[k] = false;
      for (const size_t other : group)
        if (other != k) result.others[k].push_back(other);
      if (!result.others[k].empty())
        result.maps[k].reasons.push_back("fits " + listOf(result.others[k], names) + ", but not " +
                                         names[0] + ": fuse them without it");
    }
    open[first] = false;
  }
  return result;
}

}  // namespace mrpt::fusion
