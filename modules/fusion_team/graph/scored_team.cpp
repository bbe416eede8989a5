// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Keeps the score of a configuration up to date. */
#include "fusion_team/graph/scored_team.h"

#include <algorithm>

#include "fusion_base/bits.h"

namespace mrpt::fusion {
namespace {

using Eigen::Isometry3d;

void unite(ObstacleSet& all, const ObstacleSet& more) {
  if (all.empty()) all.resize(more.size());
  for (size_t w = 0; w < more.size(); w++) all[w] |= more[w];
}

/** Returns the number of obstacles in a set that are not in another set. */
double countOfNew(const ObstacleSet& more, const ObstacleSet& known) {
  if (known.empty()) return countOf(more);
  size_t n = 0;
  for (size_t w = 0; w < more.size(); w++) n += static_cast<size_t>(countBits(more[w] & ~known[w]));
  return static_cast<double>(n);
}

/** Share of the maps that see a conflict, of the maps that compare an obstacle. */
struct ConflictShare {
  double displaced, contradicted;
};
ConflictShare shareOf(unsigned confirmed, unsigned displaced, unsigned contradicted) {
  const unsigned all = confirmed + displaced + contradicted;
  return all == 0 ? ConflictShare{0, 0}
                  : ConflictShare{double(displaced) / all, double(contradicted) / all};
}

/** Calls \a visit for each obstacle in a word of a set. \a w: index of the word. */
template <class Visitor>
void forEachIn(uint64_t word, size_t w, const Visitor& visit) {
  for (; word; word &= word - 1) visit(64 * w + static_cast<size_t>(lowestBit(word)));
}

bool has(const ObstacleSet& set, size_t i) { return set[i / 64] >> (i % 64) & 1; }

}  // namespace

void ObstacleCounts::add(const ObstacleSet& set) {
  if (digit_.front().empty())
    for (ObstacleSet& digit : digit_) digit.resize(set.size());
  for (size_t w = 0; w < set.size(); w++) {
    uint64_t carry = set[w];
    for (ObstacleSet& digit : digit_) {
      const uint64_t next = digit[w] & carry;
      digit[w] ^= carry;
      carry = next;
    }
    for (ObstacleSet& digit : digit_) digit[w] |= carry;  // stays at kMost
  }
}

unsigned ObstacleCounts::operator[](size_t i) const {
  if (digit_.front().empty()) return 0;
  unsigned count = 0;
  for (size_t k = 0; k < kDigits; k++) count |= unsigned(digit_[k][i / 64] >> (i % 64) & 1) << k;
  return count;
}

ConflictShares conflictShares(const KnownObstacles& known) {
  ConflictShares sum;
  for (size_t w = 0; w < known.displaced.size(); w++)
    forEachIn(known.displaced[w] | known.contradicted[w], w, [&](size_t i) {
      const ConflictShare share =
          shareOf(known.times_confirmed[i], known.times_displaced[i], known.times_contradicted[i]);
      sum.displaced += share.displaced;
      sum.contradicted += share.contradicted;
    });
  return sum;
}

void unite(KnownObstacles& all, const ComparedObstacles& more, Standing standing) {
  if (standing == Standing::Parted) return unite(all.denied, more.confirmed);
  const bool is_sure = standing == Standing::Sure;
  unite(all.confirmed, more.confirmed);
  all.times_confirmed.add(more.confirmed);
  unite(is_sure ? all.explained : all.displaced, more.displaced);
  unite(is_sure ? all.explained : all.contradicted, more.contradicted);
  if (is_sure) return;
  all.times_displaced.add(more.displaced);
  all.times_contradicted.add(more.contradicted);
}

ScoredTeam::ScoredTeam(const Configuration& configuration, const TeamEvidence& evidence)
    : evidence_(&evidence),
      pose_(evidence.size()),
      box_(evidence.size()),
      relations_(evidence.size()),
      parted_(evidence.size()),
      known_(evidence.size()) {
  for (size_t k = 0; k < configuration.pose.size(); k++)
    if (configuration.pose[k]) place(k, *configuration.pose[k]);
}

double ScoredTeam::score() const {
  double sum = 0;
  for (size_t k = 0; k < known_.size(); k++) sum += scoreOf(known_[k], k);
  return sum;
}

double ScoredTeam::deniedArea() const {
  double sum = 0;
  for (size_t k = 0; k < known_.size(); k++)
    sum += evidence_->areaOfObstacle(k) * countOf(known_[k].denied);
  return sum;
}

Isometry3d ScoredTeam::poseOfB(size_t map, const Isometry3d& T, size_t placed) const {
  const Isometry3d T_map_placed = T.inverse() * *pose_[placed];
  return map < placed ? T_map_placed : T_map_placed.inverse();
}

Relation ScoredTeam::relation(size_t map, const Isometry3d& T, size_t placed) const {
  const auto [a, b] = std::minmax(map, placed);
  const Isometry3d T_a_b = poseOfB(map, T, placed);
  return {&evidence_->near(a, b, T_a_b), a == map,
          evidence_->isSure(a, b, T_a_b) ? Standing::Sure : Standing::Unsure};
}

std::optional<Relation> ScoredTeam::partedRelation(size_t map, const Isometry3d& T,
                                                   size_t placed) const {
  const auto [a, b] = std::minmax(map, placed);
  const auto sure = evidence_->sureMatch(a, b);
  if (!sure || evidence_->isSame(b, poseOfB(map, T, placed), *sure)) return std::nullopt;
  return Relation{&evidence_->near(a, b, *sure), a == map, Standing::Parted};
}

std::vector<std::pair<size_t, Relation>> ScoredTeam::partedRelations(size_t map,
                                                                     const Isometry3d& T) const {
  std::vector<std::pair<size_t, Relation>> parted;
  for (size_t k = 0; k < pose_.size(); k++) {
    if (!pose_[k]) continue;
    if (const auto r = partedRelation(map, T, k)) parted.emplace_back(k, *r);
  }
  return parted;
}

std::vector<size_t> ScoredTeam::mapsAt(const Eigen::AlignedBox3d& box) const {
  std::vector<size_t> maps;
  for (size_t k = 0; k < pose_.size(); k++)
    if (pose_[k] && box_[k].intersects(box)) maps.push_back(k);
  return maps;
}

void ScoredTeam::place(size_t map, const Isometry3d& T) {
  box_[map] = boxAt(map, T);
  const auto relate = [&](size_t other, const Relation& r, auto& relations) {
    relations[map].emplace_back(other, r);
    relations[other].emplace_back(map, r.inverse());
    unite(known_[map], r.own(), r.standing);
    unite(known_[other], r.others(), r.standing);
  };
  for (const size_t other : mapsAt(box_[map])) {
    const Relation r = relation(map, T, other);
    if (!r.own().confirmed.empty()) relate(other, r, relations_);
  }
  for (const auto& [other, r] : partedRelations(map, T)) relate(other, r, parted_);
  pose_[map] = T;
}

void ScoredTeam::remove(size_t map) {
  for (const size_t other : concernedBy(map)) {
    known_[other] = {};
    for (auto* of_other : {&relations_[other], &parted_[other]}) {
      of_other->erase(std::remove_if(of_other->begin(), of_other->end(),
                                     [&](const auto& entry) { return entry.first == map; }),
                      of_other->end());
      for (const auto& [k, r] : *of_other) unite(known_[other], r.own(), r.standing);
    }
  }
  relations_[map].clear();
  parted_[map].clear();
  known_[map] = {};
  pose_[map].reset();
}

double ScoredTeam::scoreOf(const KnownObstacles& o, size_t map) const {
  const ConflictTolerance tolerance = evidence_->tolerance(map);
  const ConflictShares conflicts = conflictShares(o);
  return evidence_->areaOfObstacle(map) *
         (countOf(o.confirmed) - conflicts.displaced / tolerance.displaced -
          conflicts.contradicted / tolerance.contradicted -
          countOf(o.explained) / tolerance.explained - countOf(o.denied));
}

std::vector<size_t> ScoredTeam::concernedBy(size_t map) const {
  std::vector<size_t> maps;
  for (const auto* list : {&relations_[map], &parted_[map]})
    for (const auto& [k, r] : *list) maps.push_back(k);
  return maps;
}

double ScoredTeam::openArea(size_t map) const {
  return evidence_->areaOf(map) - evidence_->areaOfObstacle(map) * countOf(known_[map].confirmed);
}

double ScoredTeam::gainOf(size_t placed, const ComparedObstacles& more, Standing standing) const {
  const KnownObstacles& known = known_[placed];
  const ConflictTolerance tolerance = evidence_->tolerance(placed);
  const double area = evidence_->areaOfObstacle(placed);
  if (standing == Standing::Parted) return -area * countOfNew(more.confirmed, known.denied);
  const bool is_sure = standing == Standing::Sure;
  double conflicts = 0;
  for (size_t w = 0; w < more.confirmed.size(); w++) {
    uint64_t changed = is_sure ? 0 : more.displaced[w] | more.contradicted[w];
    if (!known.displaced.empty())
      changed |= more.confirmed[w] & (known.displaced[w] | known.contradicted[w]);
    forEachIn(changed, w, [&](size_t i) {
      const unsigned c = known.times_confirmed[i], d = known.times_displaced[i],
                     x = known.times_contradicted[i];
      const ConflictShare before = shareOf(c, d, x),
                          after = shareOf(c + has(more.confirmed, i),
                                          d + (!is_sure && has(more.displaced, i)),
                                          x + (!is_sure && has(more.contradicted, i)));
      conflicts += (after.displaced - before.displaced) / tolerance.displaced +
                   (after.contradicted - before.contradicted) / tolerance.contradicted;
    });
  }
  if (is_sure)  // the two sets are disjoint
    conflicts += (countOfNew(more.displaced, known.explained) +
                  countOfNew(more.contradicted, known.explained)) /
                 tolerance.explained;
  return area * (countOfNew(more.confirmed, known.confirmed) - conflicts);
}

Addition::Addition(size_t map, const Isometry3d& T, const ScoredTeam& team, double least)
    : map_(map), T_(T), least_(least), box_(team.boxAt(map, T)), open_(team.mapsAt(box_)) {
  // The nearest map says most.
  const auto distance = [&](size_t k) {
    return (team.box(k).center() - box_.center()).squaredNorm();
  };
  std::stable_sort(open_.begin(), open_.end(),
                   [&](size_t i, size_t j) { return distance(i) > distance(j); });
  for (const auto& [k, r] : team.partedRelations(map, T)) add(k, r);
}

void Addition::add(size_t placed, const Relation& r) {
  asked_.emplace_back(placed, r);
  unite(known_, r.own(), r.standing);
}

double Addition::openArea(const ScoredTeam& team) const {
  const TeamEvidence& evidence = team.evidence();
  double area = evidence.areaOf(map_) - evidence.areaOfObstacle(map_) * countOf(known_.confirmed);
  for (const size_t k : open_) area += team.openArea(k);
  return area;
}

double Addition::gain(const ScoredTeam& team) {
  if (is_current_) return gain_;
  double of_others = 0;
  for (const auto& [k, r] : asked_) of_others += team.gainOf(k, r.others(), r.standing);
  gain_ = of_others + team.scoreOf(known_, map_);
  while (!open_.empty() && gain_ + openArea(team) > least_) {
    const size_t k = open_.back();
    open_.pop_back();
    const Relation r = team.relation(map_, T_, k);
    if (r.own().confirmed.empty()) continue;
    add(k, r);
    of_others += team.gainOf(k, r.others(), r.standing);
    gain_ = of_others + team.scoreOf(known_, map_);
  }
  if (!open_.empty()) gain_ = std::min(gain_, least_);
  is_current_ = true;
  return gain_;
}

void Addition::update(const ScoredTeam& team, size_t placed, const std::vector<bool>& changed) {
  if (team.box(placed).intersects(box_)) {
    open_.push_back(placed);
    is_current_ = false;
  }
  if (const auto parted = team.partedRelation(map_, T_, placed)) {
    add(placed, *parted);
    is_current_ = false;
  }
  const auto is_changed = [&](size_t k) { return changed[k]; };
  is_current_ = is_current_ && std::none_of(open_.begin(), open_.end(), is_changed) &&
                std::none_of(asked_.begin(), asked_.end(),
                             [&](const auto& entry) { return changed[entry.first]; });
}

}  // namespace mrpt::fusion
