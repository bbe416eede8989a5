// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Searches the poses of a team at which all pairs of maps agree best. */
#include "fusion_team/graph/configuration.h"

#include <algorithm>
#include <utility>

#include "fusion_team/graph/pose_graph.h"

namespace mrpt::fusion {
namespace {

using Eigen::Isometry3d;

/** Returns the pose that a way from map \a from gives to the other map of the way. */
Isometry3d poseBy(const Way& way, size_t from, const Isometry3d& T_from) {
  return way.a == from ? T_from * way.T_a_b : T_from * way.T_a_b.inverse();
}

/** Places missing maps one after another while the score grows. */
class TeamGrowth {
 public:
  TeamGrowth(ScoredTeam& team, const TeamWays& ways)
      : team_(team), ways_(ways), additions_(ways.n()) {
    for (size_t k = 0; k < ways.n(); k++)
      if (team.isPlaced(k)) addFrom(k);
  }
  /** After a move: looks only at the maps that were taken out, and at other missing maps where they
   * meet the places of these maps. Elsewhere nothing has changed. */
  TeamGrowth(ScoredTeam& team, const TeamWays& ways, const std::vector<Placement>& taken_out)
      : team_(team), ways_(ways), additions_(ways.n()), taken_out_(&taken_out) {
    for (const auto& [map, T] : taken_out) changed_.push_back(team.boxAt(map, T));
    for (size_t k = 0; k < ways.n(); k++)
      if (team.isPlaced(k)) addFrom(k);
  }

  /** \return The maps that have been placed. */
  std::vector<size_t> run(GrowthOrder order) {
    std::vector<size_t> placed;
    while (const Addition* next = best(order)) {
      placed.push_back(next->map());
      place(next->map(), Isometry3d(next->pose()));
    }
    return placed;
  }

 private:
  void place(size_t map, const Isometry3d& T) {
    team_.place(map, T);
    additions_[map].clear();
    std::vector<bool> is_changed(ways_.n(), false);
    for (const size_t k : team_.concernedBy(map)) is_changed[k] = true;
    for (auto& of_map : additions_)
      for (Addition& addition : of_map) addition.update(team_, map, is_changed);
    if (taken_out_ && !wasThere(map, T)) {
      changed_.push_back(team_.box(map));
      for (size_t k = 0; k < ways_.n(); k++)
        if (team_.isPlaced(k)) addFrom(k);
    } else {
      addFrom(map);
    }
  }

  bool wasThere(size_t map, const Isometry3d& T) const {
    return std::any_of(taken_out_->begin(), taken_out_->end(), [&](const Placement& p) {
      return p.map == map && team_.evidence().isSame(map, p.T, T);
    });
  }

  bool isTouched(size_t map, const Isometry3d& T) const {
    const auto is_map = [&](const Placement& p) { return p.map == map; };
    if (!taken_out_ || std::any_of(taken_out_->begin(), taken_out_->end(), is_map)) return true;
    const Eigen::AlignedBox3d box = team_.boxAt(map, T);
    return std::any_of(changed_.begin(), changed_.end(),
                       [&](const auto& other) { return other.intersects(box); });
  }

  /** Adds the places that a placed map gives to missing maps. */
  void addFrom(size_t from) {
    for (const size_t i : ways_.of[from]) {
      const Way& way = ways_.all[i];
      const size_t map = way.a == from ? way.b : way.a;
      if (team_.isPlaced(map)) continue;
      const Isometry3d T = poseBy(way, from, *team_.pose(from));
      const auto is_there = [&](const Addition& k) {
        return team_.evidence().isNearlySame(map, k.pose(), T);
      };
      auto& of_map = additions_[map];
      if (isTouched(map, T) && std::none_of(of_map.begin(), of_map.end(), is_there))
        of_map.emplace_back(map, T, team_);
    }
  }

  bool isSamePlace(const Addition& g, const Addition& h) const {
    return team_.evidence().isSame(g.map(), g.pose(), h.pose());
  }

  /** Returns what to place next, or nothing if nothing increases the score. */
  const Addition* best(GrowthOrder order) {
    const Addition* next = nullptr;
    double largest = 0;
    for (auto& of_map : additions_) {
      const Addition* best_of_map = nullptr;
      double gain = 0, second = 0;  // of the best place, and of the best other place
      for (Addition& addition : of_map) {
        if (addition.gain(team_) <= gain) continue;
        gain = addition.gain(team_);
        best_of_map = &addition;
      }
      if (!best_of_map) continue;
      if (order == GrowthOrder::Clearest)
        for (Addition& addition : of_map)
          if (addition.gain(team_) > second && !isSamePlace(*best_of_map, addition))
            second = addition.gain(team_);
      if (next && gain - second <= largest) continue;
      next = best_of_map;
      largest = gain - second;
    }
    return next;
  }

  ScoredTeam& team_;
  const TeamWays& ways_;
  std::vector<std::vector<Addition>> additions_;  // by map
  const std::vector<Placement>* taken_out_ = nullptr;
  std::vector<Eigen::AlignedBox3d> changed_;  // where the maps have changed
};

/** Moves the maps of a configuration. */
class Improvement {
 public:
  Improvement(ScoredTeam& team, const TeamWays& ways)
      : team_(team), ways_(ways), is_new_(ways.n(), true) {}

  void run(Moves moves) {
    const size_t n = ways_.n();
    TeamGrowth(team_, ways_).run(GrowthOrder::LargestGain);
    for (bool is_better = true; is_better;) {
      is_better = false;
      const std::vector<bool> look = std::exchange(is_new_, std::vector<bool>(n, false));
      const auto isNew = [&](size_t k) { return look[k] || is_new_[k]; };
      for (size_t i = 0; i < n; i++)
        for (size_t j = i; j < (moves == Moves::OfOneMap ? i + 1 : n); j++)
          if ((isNew(i) || isNew(j)) && (i == j || areRelated(i, j)))
            for (const GrowthOrder order : {GrowthOrder::LargestGain, GrowthOrder::Clearest})
              if (team_.isPlaced(i) && team_.isPlaced(j)) is_better |= move(i, j, order);
    }
  }

 private:
  bool areRelated(size_t i, size_t j) const {
    const auto& relations = team_.relations(i);
    return ways_.connects(i, j) || std::any_of(relations.begin(), relations.end(),
                                               [&](const auto& r) { return r.first == j; });
  }

  /** Takes one or two maps out and lets the team grow again. \return True if the score is larger.
   */
  bool move(size_t i, size_t j, GrowthOrder order) {
    constexpr double kLeastGain = 1e-6;  // share of the score
    const double score = team_.score();
    std::vector<Placement> before{{i, *team_.pose(i)}};
    if (j != i) before.push_back({j, *team_.pose(j)});
    std::vector<size_t> touched;
    for (const Placement& p : before) {
      for (const size_t k : team_.concernedBy(p.map)) touched.push_back(k);
      team_.remove(p.map);
    }
    const std::vector<size_t> placed = TeamGrowth(team_, ways_, before).run(order);
    if (team_.score() > score * (1 + kLeastGain)) {
      for (const Placement& p : before) touched.push_back(p.map);
      touched.insert(touched.end(), placed.begin(), placed.end());
      for (const size_t k : touched) setNew(k);
      return true;
    }
    for (const size_t k : placed) team_.remove(k);
    for (const Placement& p : before) team_.place(p.map, p.T);
    return false;
  }

  /** Marks the maps whose moves may have another result, because a map has changed. */
  void setNew(size_t map) {
    is_new_[map] = true;
    for (const size_t k : team_.concernedBy(map)) is_new_[k] = true;
    for (const size_t i : ways_.of[map]) is_new_[ways_.all[i].a] = is_new_[ways_.all[i].b] = true;
  }

  ScoredTeam& team_;
  const TeamWays& ways_;
  std::vector<bool> is_new_;  // maps whose surroundings have changed since they were moved
};

}  // namespace

void settle(Configuration& c, const TeamEvidence& evidence) {
  constexpr size_t kMostRounds = 4;  // the evidence changes with the poses
  ScoredTeam team(c, evidence);
  for (size_t round = 0; round < kMostRounds; round++) {
    std::vector<PoseConstraint> constraints;
    for (size_t i = 0; i < c.pose.size(); i++)
      for (const auto& [j, r] : team.relations(i))
        if (const auto& registered = r.evidence->registered; j > i && registered)
          constraints.push_back(
              constraintOf(i, j, *registered, evidence.covariance(i, j, *registered)));
    std::sort(constraints.begin(), constraints.end(), [](const auto& g, const auto& h) {
      return std::pair(g.a, g.b) < std::pair(h.a, h.b);
    });
    Configuration settled = c;
    optimizePoses(constraints, settled.pose);
    ScoredTeam settled_team(settled, evidence);
    settled.score = settled_team.score();
    if (settled.score <= c.score) return;
    c = std::move(settled);
    team = std::move(settled_team);
  }
}

TeamAreas areasOf(size_t k, const ScoredTeam& team) {
  TeamAreas areas;
  const auto add = [&](const KnownObstacles& of_map, size_t map) {
    const double area = team.evidence().areaOfObstacle(map);
    areas.confirmed += area * countOf(of_map.confirmed);
    areas.displaced += area * countOf(of_map.displaced);
    areas.contradicted += area * countOf(of_map.contradicted);
    areas.explained += area * countOf(of_map.explained);
  };
  for (const auto& [i, r] : team.relations(k)) {
    KnownObstacles of_i;
    unite(of_i, r.others(), r.standing);
    add(of_i, i);
  }
  add(team.known(k), k);
  return areas;
}

double scoreOf(const Configuration& c, const TeamEvidence& evidence) {
  return ScoredTeam(c, evidence).score();
}

Configuration with(const Configuration& c, const std::vector<size_t>& maps,
                   const TeamEvidence& evidence) {
  Configuration some;
  some.pose.resize(c.pose.size());
  for (const size_t k : maps) some.pose[k] = c.pose[k];
  some.score = scoreOf(some, evidence);
  return some;
}

Configuration without(const Configuration& c, const std::vector<size_t>& maps,
                      const TeamEvidence& evidence) {
  Configuration rest = c;
  for (const size_t k : maps) rest.pose[k].reset();
  rest.score = scoreOf(rest, evidence);
  return rest;
}

Configuration pairOf(const Way& way, const TeamEvidence& evidence) {
  Configuration c;
  c.pose.resize(evidence.size());
  c.pose[way.a] = Isometry3d::Identity();
  c.pose[way.b] = way.T_a_b;
  c.score = scoreOf(c, evidence);
  return c;
}

Configuration grownFrom(const Way& seed, const TeamWays& ways, const TeamEvidence& evidence,
                        GrowthOrder order) {
  ScoredTeam team(pairOf(seed, evidence), evidence);
  TeamGrowth(team, ways).run(order);
  return team.configuration();
}

void improve(Configuration& c, const TeamWays& ways, const TeamEvidence& evidence, Moves moves) {
  ScoredTeam team(c, evidence);
  Improvement(team, ways).run(moves);
  c = team.configuration();
}

}  // namespace mrpt::fusion
