// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Compares the sources of maps. */
#include "fusion_team/ledger/identity.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <utility>

namespace mrpt::fusion {
namespace {

bool isSameMapOfRobot(const SourceId& s, const SourceId& t) {
  return !s.robot.empty() && s.robot == t.robot && s.map == t.map;
}

/** True if the observations of a source are among those of another source. */
bool holds(const SourceId& s, const SourceId& part) {
  return s.content_hash == part.content_hash ||
         (isSameMapOfRobot(s, part) && s.sequence > part.sequence);
}

bool holdsAll(const Sources& all, const Sources& parts) {
  return std::all_of(parts.begin(), parts.end(), [&](const SourceId& part) {
    return std::any_of(all.begin(), all.end(), [&](const SourceId& s) { return holds(s, part); });
  });
}

/** For each map, the other maps with the voxels or the robot of one of its sources, ascending. */
std::vector<std::set<size_t>> neighboursOf(const std::vector<const Sources*>& maps) {
  std::map<uint64_t, std::vector<size_t>> by_content;
  std::map<std::pair<std::string, std::string>, std::vector<size_t>> by_robot;
  const auto forEachGroup = [&](const SourceId& s, auto&& f) {
    f(by_content[s.content_hash]);
    if (!s.robot.empty()) f(by_robot[{s.robot, s.map}]);
  };
  for (size_t i = 0; i < maps.size(); i++)
    for (const SourceId& s : *maps[i])
      forEachGroup(s, [&](std::vector<size_t>& group) { group.push_back(i); });
  std::vector<std::set<size_t>> neighbours(maps.size());
  for (size_t i = 0; i < maps.size(); i++)
    for (const SourceId& s : *maps[i])
      forEachGroup(s, [&](const std::vector<size_t>& group) {
        for (const size_t j : group)
          if (j != i) neighbours[i].insert(j);
      });
  return neighbours;
}

}  // namespace

std::vector<Share> sharesOf(const std::vector<const Sources*>& maps) {
  std::vector<Share> shares(maps.size());
  const auto neighbours = neighboursOf(maps);
  for (size_t i = maps.size(); i-- > 0;)  // the last of equal maps is dropped first
    for (const size_t j : neighbours[i]) {
      if (shares[j].counting != Counting::All || !holdsAll(*maps[j], *maps[i])) continue;
      const bool is_copy = maps[i]->size() == 1 && maps[j]->size() == 1 &&
                           maps[i]->front().content_hash == maps[j]->front().content_hash;
      shares[i] = {is_copy ? Counting::Copy : Counting::None, j};
      break;
    }
  std::vector<size_t> order(maps.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t i, size_t j) { return maps[i]->size() > maps[j]->size(); });
  std::vector<bool> counts(maps.size());
  for (const size_t i : order) {
    if (shares[i].counting != Counting::All) continue;
    const auto with = std::find_if(neighbours[i].begin(), neighbours[i].end(),
                                   [&](size_t j) { return counts[j]; });
    counts[i] = with == neighbours[i].end();
    if (!counts[i]) shares[i] = {Counting::UnknownSpace, *with};
  }
  return shares;
}

void addSources(const Sources& more, Sources& all) {
  for (const SourceId& s : more) {
    const auto same = std::find_if(all.begin(), all.end(), [&](const SourceId& t) {
      return t.content_hash == s.content_hash &&
             (t.robot.empty() || s.robot.empty() || isSameMapOfRobot(s, t));
    });
    if (same == all.end())
      all.push_back(s);
    else if (!s.robot.empty() && (same->robot.empty() || s.sequence > same->sequence))
      *same = s;
  }
}

}  // namespace mrpt::fusion
