// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Divides a team into the maps that hold together with the first map, and other groups. */
#include "fusion_team/graph/team_groups.h"

#include <algorithm>
#include <optional>

#include "fusion_team/graph/configuration.h"
#include "fusion_team/graph/team_search.h"

namespace mrpt::fusion {
namespace {

/** Configurations that the search grows, for each map and in all. */
constexpr size_t kStartsPerMap = 3, kMostStarts = 24;

/** Returns the placed map that contributes least to the score, of the maps that nothing connects
 * with the first map. */
std::optional<size_t> weakestOf(const TeamSearchResult& found, const std::vector<PlacedMap>& maps,
                                const TeamEvidence& evidence) {
  std::optional<size_t> weakest;
  double best_score = 0;
  for (size_t k = 0; k < maps.size(); k++) {
    if (k == found.first || maps[k].confirmed || !found.best.pose[k]) continue;
    Configuration rest = found.best;
    rest.pose[k].reset();
    const double score = scoreOf(rest, evidence);
    if (weakest && score <= best_score) continue;
    weakest = k;
    best_score = score;
  }
  return weakest;
}

/** Places maps in the frame of one of them. \param[in] maps True for the maps to place. */
std::vector<PlacedMap> placeFrom(size_t first, std::vector<bool> maps,
                                 const std::vector<JudgedWay>& ways, const TeamEvidence& evidence,
                                 const std::vector<std::string>& names,
                                 const JointVerdictParams& params) {
  std::vector<PlacedMap> result(maps.size());
  while (true) {
    std::vector<Way> present;
    for (const JudgedWay& w : ways)
      if (maps[w.way.a] && maps[w.way.b]) present.push_back(w.way);
    const auto n = static_cast<size_t>(std::count(maps.begin(), maps.end(), true));
    const TeamSearchResult found =
        searchTeam(present, evidence, std::min(kMostStarts, kStartsPerMap * n), first);
    const std::vector<PlacedMap> judged = judgeTeam(found, ways, evidence, names, params);
    for (size_t k = 0; k < maps.size(); k++)
      if (maps[k]) result[k] = judged[k];
    const auto weakest = weakestOf(found, judged, evidence);
    if (!weakest) return result;
    maps[*weakest] = false;
  }
}

}  // namespace

PlacedGroups placeGroups(const std::vector<JudgedWay>& ways, const TeamEvidence& evidence,
                         const std::vector<std::string>& names, const JointVerdictParams& params) {
  const size_t n = evidence.size();
  std::vector<bool> open(n, true);
  PlacedGroups result{placeFrom(0, open, ways, evidence, names, params), {}};
  result.others.resize(n);
  for (size_t k = 0; k < n; k++) open[k] = !result.maps[k].placed;
  for (size_t first = 0; first < n; first++) {
    if (!open[first]) continue;
    const auto placed = placeFrom(first, open, ways, evidence, names, params);
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
