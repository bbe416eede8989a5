// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Fuses maps by greedy growth: the map with the most probable accepted match joins first. */
#include <mrpt/core/exceptions.h>
#include <mrpt/fusion/many_maps.h>

#include <algorithm>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fusion_base/error_text.h"
#include "fusion_core/pair/align_from.h"
#include "fusion_team/graph/fuse_with_memory.h"
#include "fusion_team/graph/team_fusion.h"
#include "fusion_team/ledger/ledger.h"
#include "fusion_team/pairs/pair_prior.h"

namespace mrpt::fusion {
namespace {

/** The growth of the first map by other maps. */
class Growth {
 public:
  Growth(const std::vector<RobotMap>& maps, const Options& options, TeamMemory& memory,
         const OnMember& on_member, const OnIteration& on_iteration)
      : maps_(maps),
        options_(options),
        memory_(memory),
        on_member_(on_member),
        on_iteration_(on_iteration),
        is_matched_(maps.size(), std::vector<bool>(maps.size(), false)) {
    for (const auto& m : maps_) result_.members.emplace_back().robot = m.robot;
    const auto first = std::find_if(maps_.begin(), maps_.end(),
                                    [](const auto& m) { return !m.map.isEdgesAlone(); });
    ASSERTMSG_(first != maps_.end(), "fuseMaps(): there is no map but edges");
    const auto i = static_cast<size_t>(first - maps_.begin());
    result_.members[i].joined = true;
    joined_.push_back(i);
  }

  /** Adds a map that has the voxels of another map. It gets the place of the other map. */
  void addCopy(size_t copy, size_t of) { copies_.emplace_back(copy, of); }

  /** Joins the maps that a team has placed. */
  void joinTeam(const std::vector<size_t>& whole, PlacedTeam placed) {
    is_team_ = true;
    result_.pairs = std::move(placed.pairs);
    for (size_t k = 0; k < whole.size(); k++) {
      FusionMember& member = result_.members[whole[k]] = std::move(placed.members[k]);
      for (FusionLink& link : member.links) link.with = whole[link.with];
      if (member.joined && whole[k] != joined_.front()) join(whole[k]);
    }
  }

  TeamState run(bool even_rejected) {
    if (!is_team_)
      while (const auto next = mostProbable(even_rejected)) join(*next);
    else if (even_rejected)  // a team has compared all its maps
      for (size_t i = 0; i < maps_.size(); i++)
        if (result_.members[i].hasMatch() && !result_.members[i].joined) join(i);
    for (const auto& [copy, of] : copies_) follow(copy, of);
    for (size_t i = 0; i < maps_.size(); i++)
      if (maps_[i].map.isEdgesAlone()) matchWithJoined(i);
    for (FusionMember& member : result_.members)
      if (!member.joined) member.links.clear();
    fuseJoined();
    return std::move(result_);
  }

 private:
  /** Matches a map with all joined maps. Its member keeps the best match. */
  void matchWithJoined(size_t i) {
    for (const size_t j : joined_) {
      if (is_matched_[i][j]) continue;
      is_matched_[i][j] = true;
      withPath(maps_[i].robot, [&] {
        const PreparedMap &a = maps_[j].map, &b = maps_[i].map;
        const Prior prior = priorOf(maps_[i], maps_[j]);
        Alignment match = memory_.pairs.match(a, b, prior, [&] {
          if (on_member_) on_member_(maps_[i].robot, joined_.size());
          return align(a, b, prior, options_, on_iteration_);
        });
        if (isBetter(match, result_.members[i])) keep(std::move(match), i, j);
      });
    }
  }

  static bool isBetter(const Alignment& match, const FusionMember& than) {
    const auto rank = [](const Evaluation& e) { return std::pair(e.accepted, e.probability); };
    return !than.hasMatch() || rank(match.evaluation) > rank(than.alignment.evaluation);
  }

  void keep(Alignment match, size_t i, size_t j) {
    FusionMember& member = result_.members[i];
    member.alignment = std::move(match);
    member.matched_with = maps_[j].robot;
    member.links = {{j, member.alignment.match.T_a_b, member.alignment.match.covariance}};
    const bool is_first = j == joined_.front();
    member.pose =
        is_first ? member.alignment.pose() : result_.members[j].pose + member.alignment.pose();
  }

  /** Gives a copy the place of its map. */
  void follow(size_t copy, size_t of) {
    const FusionMember& twin = result_.members[of];
    FusionMember& member = result_.members[copy];
    const PreparedMap &a = maps_[of].map, &b = maps_[copy].map;
    const auto T = Eigen::Isometry3d::Identity();
    Alignment same =
        memory_.pairs.registration(a, b, T, [&] { return alignFrom(a, b, T, options_); });
    same.evaluation.accepted = twin.joined;
    same.evaluation.is_ambiguous = false;
    same.evaluation.reasons = {"has the same voxels as the map of " + twin.robot};
    same.evaluation.reasons_against = twin.joined ? 0 : 1;
    keep(std::move(same), copy, of);
    member.pose = twin.pose;
    if (twin.joined) join(copy);
  }

  bool isCopy(size_t i) const {
    return std::any_of(copies_.begin(), copies_.end(), [&](const auto& c) { return c.first == i; });
  }

  /** Returns the map with the most probable match that may join, or nothing. */
  std::optional<size_t> mostProbable(bool even_rejected) {
    std::optional<size_t> best;
    for (size_t i = 0; i < maps_.size(); i++) {
      if (result_.members[i].joined || maps_[i].map.isEdgesAlone() || isCopy(i)) continue;
      matchWithJoined(i);
      const Evaluation& e = result_.members[i].alignment.evaluation;
      if ((e.accepted || even_rejected) &&
          (!best || e.probability > result_.members[*best].alignment.evaluation.probability))
        best = i;
    }
    return best;
  }

  void join(size_t i) {
    result_.members[i].joined = true;
    joined_.push_back(i);
  }

  Sources sourcesOf(size_t i) const {
    const Sources& known = maps_[i].map.sources();
    return known.empty() ? Sources{{{}, maps_[i].robot, 0, 0}} : known;
  }

  /** Returns the name of a map in the ledger. The number tells robots of one name apart. */
  SourceName nameOf(size_t i) const {
    const bool is_twice = std::count_if(maps_.begin(), maps_.end(), [&](const RobotMap& m) {
                            return m.robot == maps_[i].robot;
                          }) > 1;
    return {maps_[i].robot, is_twice ? std::to_string(i) : std::string()};
  }

  /** Makes the ledger hold the joined maps at their poses. \return The maps by their names. */
  std::map<SourceName, size_t> updateLedger() {
    const SourceName reference = nameOf(joined_.front());
    if (!memory_.ledger || !(memory_.reference == reference))
      memory_.ledger.emplace(LedgerParams{options_.merge, reference, options_.merge.independent});
    memory_.reference = reference;
    Ledger& ledger = *memory_.ledger;
    std::map<SourceName, size_t> maps;
    for (const size_t i : joined_) maps[nameOf(i)] = i;
    for (const LedgerEntry& entry : ledger.entries())
      if (!maps.count(entry.source.name())) ledger.remove(entry.source.name());
    for (const auto& [name, i] : maps) {
      const Eigen::Isometry3d pose = toEigen(result_.members[i].pose.mean);
      if (!ledger.holds(name, maps_[i].map.octree(), sourcesOf(i)))
        ledger.add(Source(name, ++memory_.sequence, maps_[i].map.octree(), sourcesOf(i)), pose);
      ledger.move(name, pose);
    }
    return maps;
  }

  /** Makes the map of all joined maps. It does not depend on the order in which they joined. */
  void fuseJoined() {
    const auto maps = updateLedger();
    for (const LedgerEntry& entry : memory_.ledger->entries()) {
      addSources(entry.source.parts(), result_.sources);
      FusionMember& member = result_.members[maps.at(entry.source.name())];
      member.counting = entry.counting;
      if (entry.with) member.counted_with = entry.with->robot;
    }
    result_.map = joined_.size() < 2 ? maps_[joined_.front()].map.octree() : memory_.ledger->map();
  }

  const std::vector<RobotMap>& maps_;
  const Options& options_;
  TeamMemory& memory_;
  const OnMember& on_member_;
  const OnIteration& on_iteration_;
  std::vector<std::vector<bool>> is_matched_;  // by the indices of both maps
  std::vector<size_t> joined_;  // joined maps in their order; the first map keeps its frame
  bool is_team_ = false;        // true after joinTeam()
  std::vector<std::pair<size_t, size_t>> copies_;  // copy, and the map with the same voxels
  TeamState result_;
};

}  // namespace

namespace {

/** Returns the indices of the maps in an order that does not depend on the order of the input, but
 * for the first whole map, which keeps its frame: the first whole map, then by name, then by
 * content. */
std::vector<size_t> canonicalOrder(const std::vector<RobotMap>& maps) {
  std::vector<size_t> order(maps.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto first = std::find_if(order.begin(), order.end(),
                                  [&](size_t i) { return !maps[i].map.isEdgesAlone(); });
  if (first != order.end()) std::rotate(order.begin(), first, first + 1);
  const auto is_before = [&](size_t i, size_t j) {
    const RobotMap &m = maps[i], &n = maps[j];
    if (m.robot != n.robot) return m.robot < n.robot;
    return m.map.contentHash() < n.map.contentHash();
  };
  if (!order.empty()) std::stable_sort(order.begin() + 1, order.end(), is_before);
  return order;
}

TeamState fuseInOrder(const std::vector<RobotMap>& maps, const Options& options, TeamMemory& memory,
                      bool even_rejected, const OnMember& on_member,
                      const OnIteration& on_iteration) {
  Growth growth(maps, options, memory, on_member, on_iteration);
  std::vector<size_t> whole;
  for (size_t i = 0; i < maps.size(); i++) {
    if (maps[i].map.isEdgesAlone()) continue;
    const auto twin = std::find_if(whole.begin(), whole.end(), [&](size_t j) {
      return maps[j].map.contentHash() == maps[i].map.contentHash();
    });
    if (twin == whole.end())
      whole.push_back(i);
    else
      growth.addCopy(i, *twin);
  }
  if (whole.size() > 2) {
    std::vector<RobotMap> of_team;
    for (const size_t i : whole) of_team.push_back(maps[i]);
    growth.joinTeam(whole, placeTeam(of_team, options, on_member, memory.pairs));
  }
  return growth.run(even_rejected);
}

}  // namespace

TeamState fuseWithMemory(const std::vector<RobotMap>& maps, const Options& options,
                         TeamMemory& memory, bool even_rejected, const OnMember& on_member,
                         const OnIteration& on_iteration) {
  const std::vector<size_t> order = canonicalOrder(maps);
  std::vector<RobotMap> in_order;
  for (const size_t i : order) in_order.push_back(maps[i]);
  TeamState result = fuseInOrder(in_order, options, memory, even_rejected, on_member, on_iteration);
  std::vector<FusionMember> members(maps.size());
  for (size_t k = 0; k < order.size(); k++) {
    for (FusionLink& link : result.members[k].links) link.with = order[link.with];
    members[order[k]] = std::move(result.members[k]);
  }
  result.members = std::move(members);
  return result;
}

ManyFused fuseMaps(const std::vector<RobotMap>& maps, const Options& options, bool even_rejected,
                   const OnMember& on_member, const OnIteration& on_iteration) {
  TeamMemory memory;
  TeamState state = fuseWithMemory(maps, options, memory, even_rejected, on_member, on_iteration);
  return {std::make_unique<octomap::OcTree>(*state.map), std::move(state.members),
          std::move(state.sources), std::move(state.pairs)};
}

}  // namespace mrpt::fusion
