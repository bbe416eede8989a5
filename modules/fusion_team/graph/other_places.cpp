// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Moves blocks of maps of a configuration to other places. */
#include "fusion_team/graph/other_places.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "fusion_team/graph/rigid_groups.h"

namespace mrpt::fusion {
namespace {

using Eigen::Isometry3d;
using Block = std::vector<size_t>;

constexpr double kWorthwhile = 0.5;     // least gain of a rival over the gain of the place
constexpr double kWorthSettling = 0.8;  // least score of a rival over the score of the place

/** Evidence in which displaced obstacles count nothing. The errors of a chain of maps displace
 * obstacles where the chain closes a loop, until they are spread over the loop. Parted sure matches
 * count nothing, too: one of them alone does not refute another place. */
class EvidenceBeforeSettling : public TeamEvidence {
 public:
  explicit EvidenceBeforeSettling(const TeamEvidence& evidence) : evidence_(evidence) {}
  size_t size() const override { return evidence_.size(); }
  const PairEvidence& near(size_t a, size_t b, const Isometry3d& T_a_b) const override {
    return evidence_.near(a, b, T_a_b);
  }
  Matrix6d covariance(size_t a, size_t b, const Isometry3d& registered) const override {
    return evidence_.covariance(a, b, registered);
  }
  bool isSame(size_t b, const Isometry3d& T, const Isometry3d& U) const override {
    return evidence_.isSame(b, T, U);
  }
  bool isNearlySame(size_t b, const Isometry3d& T, const Isometry3d& U) const override {
    return evidence_.isNearlySame(b, T, U);
  }
  bool isSure(size_t a, size_t b, const Isometry3d& T_a_b) const override {
    return evidence_.isSure(a, b, T_a_b);
  }
  std::optional<Isometry3d> sureMatch(size_t, size_t) const override { return std::nullopt; }
  Eigen::AlignedBox3d box(size_t map) const override { return evidence_.box(map); }
  double areaOfObstacle(size_t map) const override { return evidence_.areaOfObstacle(map); }
  double areaOf(size_t map) const override { return evidence_.areaOf(map); }
  ConflictTolerance tolerance(size_t map) const override {
    ConflictTolerance tolerance = evidence_.tolerance(map);
    tolerance.displaced = std::numeric_limits<double>::infinity();
    return tolerance;
  }

 private:
  const TeamEvidence& evidence_;
};

/** A link of two placed maps. */
struct Edge {
  double score;  // of both maps alone
  size_t a, b;
};

/** Returns the tree of the links with the largest scores; several trees if links are missing. */
std::vector<Edge> strongestTree(const ScoredTeam& team) {
  const size_t n = team.evidence().size();
  std::vector<Edge> edges, tree;
  for (size_t a = 0; a < n; a++)
    for (const auto& [b, r] : team.relations(a)) {
      if (b < a) continue;
      KnownObstacles of_a, of_b;
      unite(of_a, r.own(), r.standing);
      unite(of_b, r.others(), r.standing);
      edges.push_back({team.scoreOf(of_a, a) + team.scoreOf(of_b, b), a, b});
    }
  std::sort(edges.begin(), edges.end(), [](const Edge& g, const Edge& h) {
    return std::make_tuple(-g.score, g.a, g.b) < std::make_tuple(-h.score, h.a, h.b);
  });
  std::vector<size_t> piece(n);
  std::iota(piece.begin(), piece.end(), 0);
  for (const Edge& e : edges) {
    if (piece[e.a] == piece[e.b]) continue;
    // By value: the elements themselves change.
    std::replace(piece.begin(), piece.end(), size_t(piece[e.a]), size_t(piece[e.b]));
    tree.push_back(e);
  }
  return tree;
}

/** Returns the maps that a tree connects with a map, without two of its edges. */
Block pieceOf(size_t map, const std::vector<Edge>& tree, size_t cut, size_t other_cut) {
  Block piece{map};
  for (size_t next = 0; next < piece.size(); next++)
    for (size_t i = 0; i < tree.size(); i++) {
      const size_t k = piece[next];
      if (i == cut || i == other_cut || (tree[i].a != k && tree[i].b != k)) continue;
      const size_t other = tree[i].a == k ? tree[i].b : tree[i].a;
      if (std::find(piece.begin(), piece.end(), other) == piece.end()) piece.push_back(other);
    }
  std::sort(piece.begin(), piece.end());
  return piece;
}

/** Returns the increase of the score by maps that join a team and keep their shape, less the score
 * of these maps alone. A value of at most 0 is not exact.
 * \param[in] block The maps at their poses. \param[in] alone Score of these maps alone. */
double joiningGain(ScoredTeam& team, const std::vector<Placement>& block, double alone) {
  double open = 0;  // each surface can be confirmed once
  std::set<size_t> met;
  for (const Placement& p : block) {
    open += team.evidence().areaOf(p.map);
    for (const size_t k : team.mapsAt(team.boxAt(p.map, p.T))) met.insert(k);
  }
  for (const size_t k : met) open += team.openArea(k);
  double gain = -alone;
  size_t placed = 0;
  for (const Placement& p : block) {
    const double least = placed + 1 < block.size() ? -gain - open : -gain;
    const double more = Addition(p.map, p.T, team, least).gain(team);
    gain += more;
    if (more <= least || placed + 1 == block.size()) break;
    team.place(p.map, p.T);
    placed++;
  }
  for (size_t i = 0; i < placed; i++) team.remove(block[i].map);
  return placed + 1 < block.size() ? std::min(gain, 0.0) : gain;
}

/** Moves a block of maps of a configuration to other places. */
class MovedBlock {
 public:
  MovedBlock(const Block& block, const Configuration& c, const TeamEvidence& evidence)
      : block_(block),
        c_(c),
        evidence_(evidence),
        before_settling_(evidence),
        others_(c, evidence),
        rest_(c, before_settling_) {
    const double whole = rest_.score();
    for (const size_t k : block) {
      rest_.remove(k);
      others_.remove(k);
    }
    alone_ = with(c, block, before_settling_).score;
    gain_ = whole - rest_.score() - alone_;
  }

  bool has(size_t map) const {
    return std::find(block_.begin(), block_.end(), map) != block_.end();
  }

  /** Adds the configuration in which the block has moved, if it gains there.
   * \param[in] asked The map of the block that is compared first. */
  void add(const Isometry3d& motion, size_t asked, std::vector<Configuration>& rivals) {
    const size_t front = block_.front();
    const Isometry3d T_front = motion * *c_.pose[front];
    const auto isThere = [&](const Isometry3d& T) {
      return evidence_.isNearlySame(front, T_front, T);
    };
    if (std::any_of(tried_.begin(), tried_.end(), isThere)) return;
    tried_.push_back(T_front);
    std::vector<Placement> moved{{asked, motion * *c_.pose[asked]}};
    for (const size_t k : block_)
      if (k != asked) moved.push_back({k, motion * *c_.pose[k]});
    const double gain_there = joiningGain(rest_, moved, alone_);
    if (gain_there <= 0) return;
    for (const Placement& p : moved) others_.place(p.map, p.T);
    Configuration rival = others_.configuration();
    for (const Placement& p : moved) others_.remove(p.map);
    if (rest_.score() + alone_ + gain_there > kWorthSettling * c_.score &&
        gain_there > kWorthwhile * gain_)
      settle(rival, evidence_);
    rivals.push_back(std::move(rival));
  }

 private:
  const Block& block_;
  const Configuration& c_;
  const TeamEvidence& evidence_;
  const EvidenceBeforeSettling before_settling_;
  ScoredTeam others_, rest_;  // the maps outside of the block; the second before settling
  double alone_, gain_;       // of the block, before settling
  std::vector<Isometry3d> tried_;
};

/** Adds the configurations in which a block is elsewhere. */
void addOtherPlaces(const Block& block, const Configuration& c, const TeamWays& ways,
                    const TeamEvidence& evidence, std::vector<Configuration>& rivals) {
  MovedBlock moved(block, c, evidence);
  for (const size_t inside : block)
    for (const size_t w : ways.of[inside]) {
      const Way& way = ways.all[w];
      const size_t outside = way.a == inside ? way.b : way.a;
      if (moved.has(outside) || !c.pose[outside]) continue;
      const Isometry3d T = *c.pose[outside] * (way.a == inside ? way.T_a_b.inverse() : way.T_a_b);
      if (evidence.isSame(inside, T, *c.pose[inside])) continue;
      // The map of the way first: its evidence is known.
      moved.add(T * c.pose[inside]->inverse(), inside, rivals);
    }
}

}  // namespace

std::vector<std::vector<size_t>> blocksOf(const Configuration& c, const TeamEvidence& evidence) {
  constexpr size_t kMostPerMap = 4;
  const ScoredTeam team(c, evidence);
  const std::vector<Edge> tree = strongestTree(team);
  const auto n = static_cast<size_t>(
      std::count_if(c.pose.begin(), c.pose.end(), [](const auto& T) { return T.has_value(); }));
  std::vector<std::pair<double, Block>> pieces;  // with the score of the links that hold them
  for (size_t i = 0; i < tree.size(); i++)
    for (size_t j = i; j < tree.size(); j++) {
      const double links = tree[i].score + (j > i ? tree[j].score : 0);
      for (const size_t k : {tree[i].a, tree[i].b, tree[j].a, tree[j].b}) {
        Block piece = pieceOf(k, tree, i, j);
        if (piece.size() > 1 && 2 * piece.size() <= n) pieces.emplace_back(links, std::move(piece));
      }
    }
  std::sort(pieces.begin(), pieces.end());
  std::vector<Block> blocks;
  for (size_t k = 0; k < c.pose.size(); k++)
    if (c.pose[k]) blocks.push_back({k});
  std::set<Block> known;
  for (auto& [links, piece] : pieces)
    if (blocks.size() < kMostPerMap * n && known.insert(piece).second)
      blocks.push_back(std::move(piece));
  return blocks;
}

std::vector<Configuration> otherPlaces(const Configuration& c, const TeamWays& ways,
                                       const TeamEvidence& evidence) {
  std::vector<Configuration> rivals;
  for (const auto& block : blocksOf(c, evidence)) addOtherPlaces(block, c, ways, evidence, rivals);
  return rivals;
}

std::vector<Configuration> crossed(const Configuration& c, const Configuration& other,
                                   const TeamEvidence& evidence) {
  const auto groups = rigidGroups(c, other, evidence);
  if (groups.size() < 2) return {};
  std::vector<Isometry3d> to_c;  // from the frame of the other configuration, by group
  for (const Block& group : groups)
    to_c.push_back(*c.pose[group.front()] * other.pose[group.front()]->inverse());
  std::vector<Configuration> result;
  for (size_t i = 0; i < groups.size(); i++) {
    MovedBlock moved(groups[i], c, evidence);
    for (size_t j = 0; j < groups.size(); j++)
      if (j != i) moved.add(to_c[j] * to_c[i].inverse(), groups[i].front(), result);
  }
  return result;
}

}  // namespace mrpt::fusion
