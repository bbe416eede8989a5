// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Decides which maps of a team are placed right. */
#include "fusion_team/graph/joint_verdict.h"

#include <algorithm>
#include <utility>

#include "fusion_base/percent_text.h"

namespace mrpt::fusion {
namespace {

using Eigen::Isometry3d;

/** A match that the configuration agrees with. */
struct Link {
  size_t a, b;
  double probability;  // of the pair's verdict
  double confirmed;    // number of confirmed obstacles at the place
};

std::vector<Link> linksOf(const Configuration& c, const std::vector<JudgedWay>& ways,
                          const TeamEvidence& evidence) {
  std::vector<Link> links;
  for (const auto& [way, probability] : ways) {
    if (!c.pose[way.a] || !c.pose[way.b]) continue;
    const Isometry3d &T_a = *c.pose[way.a], &T_b = *c.pose[way.b];
    if (!evidence.isSame(way.b, T_a * way.T_a_b, T_b)) continue;
    const auto same = std::find_if(links.begin(), links.end(), [&, w = &way](const Link& l) {
      return l.a == w->a && l.b == w->b;
    });
    if (same != links.end()) {  // two hypotheses of one pair are one witness
      same->probability = std::max(same->probability, probability);
      continue;
    }
    const PairEvidence& e = evidence.near(way.a, way.b, T_a.inverse() * T_b);
    links.push_back({way.a, way.b, probability, e.confirmed()});
  }
  return links;
}

/** Returns the maps that links connect with a map. \a without is not used. */
std::vector<bool> connectedWith(size_t first, size_t n, const std::vector<Link>& links,
                                const Link* without = nullptr) {
  std::vector<bool> reached(n);
  std::vector<size_t> open{first};
  reached[first] = true;
  while (!open.empty()) {
    const size_t k = open.back();
    open.pop_back();
    for (const Link& link : links) {
      if (&link == without || (link.a != k && link.b != k)) continue;
      const size_t other = link.a == k ? link.b : link.a;
      if (!reached[other]) open.push_back(other);
      reached[other] = true;
    }
  }
  return reached;
}

/** Removes links that no loop confirms and that are not sure. */
std::vector<Link> confirmedLinks(const std::vector<Link>& links, size_t n,
                                 double least_probability) {
  std::vector<Link> confirmed;
  for (const Link& link : links)
    if (link.probability >= least_probability || connectedWith(link.a, n, links, &link)[link.b])
      confirmed.push_back(link);
  return confirmed;
}

/** Sets the parents: the path of each map to the first map uses the links with the most evidence.
 */
void setParents(size_t first, std::vector<Link> links, std::vector<PlacedMap>& maps) {
  std::stable_sort(links.begin(), links.end(),
                   [](const Link& g, const Link& h) { return g.confirmed > h.confirmed; });
  std::vector<bool> reached(maps.size());
  reached[first] = true;
  for (bool grows = true; grows;) {
    grows = false;
    for (const Link& link : links) {
      if (reached[link.a] == reached[link.b]) continue;
      const bool from_a = reached[link.a];
      maps[from_a ? link.b : link.a].parent = from_a ? link.a : link.b;
      reached[link.a] = reached[link.b] = grows = true;
      break;
    }
  }
}

/** Returns the share of the surface of one of two maps that the other map confirms, the larger
 * share of both. */
double overlapOf(size_t i, size_t j, const Configuration& c, const TeamEvidence& evidence) {
  const size_t a = std::min(i, j), b = std::max(i, j);
  const PairEvidence& e = evidence.near(a, b, c.pose[a]->inverse() * *c.pose[b]);
  const auto share = [&](const ComparedObstacles& of_map, size_t map) {
    return evidence.areaOfObstacle(map) * countOf(of_map.confirmed) / evidence.areaOf(map);
  };
  return std::min(1.0, std::max(share(e.of_a, a), share(e.of_b, b)));
}

/** Returns the reason against the place of a map; empty without one. */
std::string doubtOn(const PlacedMap& m, const JointVerdictParams& params) {
  if (m.runner_up > params.max_runner_up)
    return "another place reaches " +
           percentBeside(params.max_runner_up, std::min(m.runner_up, 9.99)) +
           " of the gain of this place, more than " + percent(params.max_runner_up);
  const double conflicts = m.areas.conflictRatio();
  if (conflicts > params.max_conflict)
    return percentBeside(params.max_conflict, conflicts) +
           " of the obstacles lie in free space of other maps, more than " +
           percent(params.max_conflict);
  if (m.probability < params.leastProbability())
    return "the place is right with a probability of " +
           percentBeside(params.leastProbability(), m.probability) + ", less than " +
           percent(params.leastProbability());
  return "";
}

}  // namespace

std::vector<std::string> reasonsAtMatch(const PlacedMap& map, const std::string& partner) {
  std::vector<std::string> reasons = map.reasons;
  if (map.pose)
    reasons.insert(reasons.begin(),
                   "the pose is that of the match with " + partner +
                       "; all maps together prefer another place, which the next reasons judge");
  return reasons;
}

std::string listOf(const std::vector<size_t>& maps, const std::vector<std::string>& names) {
  std::string list;
  for (const size_t k : maps) list += (list.empty() ? "" : ", ") + names[k];
  return list;
}

std::vector<double> overlapsWith(size_t first, const Configuration& c,
                                 const TeamEvidence& evidence) {
  std::vector<double> overlap(c.pose.size(), 0);
  std::vector<bool> is_reached(c.pose.size(), false);
  overlap[first] = 1;
  while (true) {
    std::optional<size_t> next;
    for (size_t k = 0; k < overlap.size(); k++)
      if (!is_reached[k] && overlap[k] > (next ? overlap[*next] : 0)) next = k;
    if (!next || !c.pose[*next]) return overlap;
    is_reached[*next] = true;
    for (size_t k = 0; k < overlap.size(); k++)
      if (!is_reached[k] && c.pose[k])
        overlap[k] =
            std::max(overlap[k], std::min(overlap[*next], overlapOf(*next, k, c, evidence)));
  }
}

std::vector<PlacedMap> judgeTeam(const TeamSearchResult& result, const std::vector<JudgedWay>& ways,
                                 const TeamEvidence& evidence,
                                 const std::vector<std::string>& names,
                                 const JointVerdictParams& params) {
  const size_t n = evidence.size();
  std::vector<PlacedMap> maps(n);
  Configuration clear = result.best;  // the maps whose places are clear
  const auto say = [&](size_t k, const std::string& reason) { maps[k].reasons.push_back(reason); };
  // A map whose place is not clear closes loops of other maps at any of its places: rivals that
  // move the other maps with it are rivals of the other maps too.
  const double least_probability = params.leastSureProbability(n);
  auto links = confirmedLinks(linksOf(result.best, ways, evidence), n, least_probability);
  const std::vector<bool> confirmed = connectedWith(result.first, n, links);
  const std::vector<double> overlaps = overlapsWith(result.first, result.best, evidence);
  const ScoredTeam team(result.best, evidence);
  for (size_t k = 0; k < n; k++) {
    PlacedMap& m = maps[k];
    m.runner_up = result.runner_up[k];
    m.confirmed = confirmed[k];
    if (!result.best.pose[k]) {
      say(k, "no place agrees with the other maps");
      continue;
    }
    m.areas = areasOf(k, team);
    m.overlap = overlaps[k];
    m.probability = params.model.probability(m.runner_up, m.overlap);
    const std::string doubt = doubtOn(m, params);
    if (doubt.empty()) continue;
    say(k, doubt);
    clear.pose[k].reset();
  }

  links.erase(std::remove_if(links.begin(), links.end(),
                             [&](const Link& l) { return !clear.pose[l.a] || !clear.pose[l.b]; }),
              links.end());
  const std::vector<bool> reached = connectedWith(result.first, n, links);
  setParents(result.first, links, maps);
  const std::optional<Isometry3d>& T_first = result.best.pose[result.first];
  for (size_t k = 0; k < n; k++) {
    PlacedMap& m = maps[k];
    for (const Link& link : links)
      if (link.a == k || link.b == k) m.ways_in.push_back(link.a == k ? link.b : link.a);
    if (T_first && result.best.pose[k]) m.pose = T_first->inverse() * *result.best.pose[k];
    m.placed = reached[k] && (k == result.first || clear.pose[k]);
    if (k == result.first || !clear.pose[k]) continue;
    if (m.ways_in.empty())
      say(k,
          "no loop of matches confirms the place, and no match alone is right with a probability "
          "of " +
              percent(least_probability));
    else if (!m.placed)
      say(k, "matches with " + listOf(m.ways_in, names) + " do not connect it with " +
                 names[result.first]);
    if (!m.placed) continue;
    say(k, "placed by " + listOf(m.ways_in, names));
    say(k, percentBeside(params.max_conflict, m.areas.conflictRatio()) +
               " of the obstacles lie in free space of other maps, at most " +
               percent(params.max_conflict) + " are allowed");
    say(k, m.runner_up > 0 ? "the next best place reaches " + percent(m.runner_up) +
                                 " of the gain of this place"
                           : "no other place agrees with the other maps");
  }
  return maps;
}

}  // namespace mrpt::fusion
