// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Fuses maps by greedy growth: the map with the most probable accepted match joins first. */
#include <mrpt/core/exceptions.h>
#include <mrpt/fusion/many_maps.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fusion_base/error_text.h"
#include "fusion_team/graph/team_fusion.h"
#include "fusion_team/ledger/ledger.h"
#include "fusion_team/pairs/pair_matches.h"

namespace mrpt::fusion {
namespace {

/** The growth of the first map by other maps. */
class Growth {
 public:
  Growth(const std::vector<RobotMap>& maps, const Options& options, const OnMember& on_member,
         const OnIteration& on_iteration)
      : maps_(maps),
        options_(options),
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

  /** Joins the maps that a team has placed. */
  void joinTeam(const std::vector<size_t>& whole, PlacedTeam placed) {
    is_team_ = true;
    result_.pairs = std::move(placed.pairs);
    for (size_t k = 0; k < whole.size(); k++) {
      FusionMember& member = result_.members[whole[k]] = std::move(placed.members[k]);
      if (member.joined && whole[k] != joined_.front()) join(whole[k]);
    }
  }

  ManyFused run(bool even_rejected) {
    if (!is_team_ || even_rejected)  // a team has compared all its maps
      while (const auto next = mostProbable(even_rejected)) join(*next);
    for (size_t i = 0; i < maps_.size(); i++)
      if (maps_[i].map.isEdgesAlone()) matchWithJoined(i);
    result_.map = fused();
    return std::move(result_);
  }

 private:
  /** Matches a map with all joined maps. Its member keeps the best match. */
  void matchWithJoined(size_t i) {
    for (const size_t j : joined_) {
      if (is_matched_[i][j]) continue;
      is_matched_[i][j] = true;
      if (on_member_) on_member_(maps_[i].robot, joined_.size());
      withPath(maps_[i].robot, [&] {
        Alignment match =
            align(maps_[j].map, maps_[i].map, priorOf(maps_[i], maps_[j]), options_, on_iteration_);
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
    const bool is_first = j == joined_.front();
    member.pose =
        is_first ? member.alignment.pose() : result_.members[j].pose + member.alignment.pose();
  }

  /** Returns the map with the most probable match that may join, or nothing. */
  std::optional<size_t> mostProbable(bool even_rejected) {
    std::optional<size_t> best;
    for (size_t i = 0; i < maps_.size(); i++) {
      if (result_.members[i].joined || maps_[i].map.isEdgesAlone()) continue;
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

  /** Returns the map of all joined maps. It does not depend on the order in which they joined. */
  std::unique_ptr<octomap::OcTree> fused() const {
    if (joined_.size() < 2)
      return std::make_unique<octomap::OcTree>(maps_[joined_.front()].map.wholeMap());
    // The number tells robots of one name apart.
    const auto nameOf = [&](size_t i) { return SourceName{maps_[i].robot, std::to_string(i)}; };
    Ledger ledger({options_.merge, nameOf(joined_.front()), false});
    for (const size_t i : joined_)
      ledger.add(Source(nameOf(i), 0, maps_[i].map.octree()),
                 toEigen(result_.members[i].pose.mean));
    return std::make_unique<octomap::OcTree>(*ledger.map());
  }

  const std::vector<RobotMap>& maps_;
  const Options& options_;
  const OnMember& on_member_;
  const OnIteration& on_iteration_;
  std::vector<std::vector<bool>> is_matched_;  // by the indices of both maps
  std::vector<size_t> joined_;  // joined maps in their order; the first map keeps its frame
  bool is_team_ = false;        // true after joinTeam()
  ManyFused result_;
};

}  // namespace

ManyFused fuseMaps(const std::vector<RobotMap>& maps, const Options& options, bool even_rejected,
                   const OnMember& on_member, const OnIteration& on_iteration) {
  Growth growth(maps, options, on_member, on_iteration);
  std::vector<size_t> whole;
  for (size_t i = 0; i < maps.size(); i++)
    if (!maps[i].map.isEdgesAlone()) whole.push_back(i);
  if (whole.size() > 2) {
    std::vector<RobotMap> of_team;
    for (const size_t i : whole) of_team.push_back(maps[i]);
    growth.joinTeam(whole, placeTeam(of_team, options, on_member));
  }
  return growth.run(even_rejected);
}

}  // namespace mrpt::fusion
