// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Fuses the maps of a team as they arrive. */
#include "fusion_link/team_view.h"

#include <mrpt/fusion/alignment.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "fusion_base/error_text.h"
#include "fusion_link/outline.h"
#include "fusion_link/wanted.h"

namespace mrpt::fusion {
namespace {

/** A part of a map is fused anew when its bytes have grown by this factor. Once it has joined, it
 * can wait longer. */
constexpr double kGrowthOfPart = 1.25, kGrowthOfJoinedPart = 2;

/** Blocks of the overlap that are wanted first, of a map that has not joined: an eighth of the map,
 * but not too few, because each wish takes a turn of the link. */
constexpr size_t kPortions = 8, kFewBlocks = 6;

/** Largest number of nodes of all maps of a team: 20 large buildings, and about 1 GB. */
constexpr size_t kMostTeamNodes = 20'000'000;

/** Returns the member of a team with a name if it has joined; null if there is none. */
const FusionMember* joinedMember(const std::string& name, const TeamState& state) {
  for (const FusionMember& member : state.members)
    if (member.robot == name && member.joined) return &member;
  return nullptr;
}

}  // namespace

MapSnapshot::MapSnapshot(const MapReplica& map)
    : source(map.source()),
      complete_version(map.completeVersion()),
      index(map.index()),
      blocks(map.blocks()),
      outline(map.outline()) {}

TeamKnowledge TeamView::update(const std::vector<MapSnapshot>& snapshots) {
  TeamKnowledge result;
  std::vector<std::string> changed;
  const auto noting = [&](const MapSnapshot& s, auto&& act) {
    try {
      act();
    } catch (const std::exception& e) {
      result.notes.push_back(nameOf(s.source) + ": " + messageOf(e));
    }
  };
  const auto look = [&](const MapSnapshot& s) {
    const std::string name = nameOf(s.source);
    noting(s, [&] { meet(s, known_[name]); });
    noting(s, [&] {
      if (take(s, known_[name])) changed.push_back(name);
    });
  };
  for (const bool is_own : {true, false})  // the others meet the own map
    for (const MapSnapshot& s : snapshots)
      if ((nameOf(s.source) == own_) == is_own) look(s);
  for (const std::string& name : changed) team_->set(*known_[name].map);
  if (const auto robots = team_->robots(); !std::is_sorted(robots.begin(), robots.end())) rebuild();
  try {
    result.state = team_->state();
    for (const FusionMember& member : result.state->members) {
      Known& known = known_.at(member.robot);
      known.has_joined = member.joined;
      result.maps.push_back(*known.map);
      result.whole_maps += known.version > 0 ? 1 : 0;
      if (known.version == 0) result.parts[member.robot] = known.bytes;
    }
  } catch (const std::exception& e) {
    result.notes.push_back(messageOf(e));
  }
  for (const MapSnapshot& s : snapshots) {
    const Known& known = known_.at(nameOf(s.source));
    if (nameOf(s.source) == own_) continue;
    if (known.version == 0 && known.meeting) result.meetings.push_back(*known.meeting);
    WantedBlocks all{s.source, {}, false};
    noting(s, [&] { all = wantedOf(s, result); });
    result.wanted.push_back(std::move(all));
  }
  return result;
}

/** Returns what is wanted of a map: blocks of the overlap, no others until the map has joined. */
WantedBlocks TeamView::wantedOf(const MapSnapshot& s, const TeamKnowledge& knowledge) const {
  WantedBlocks wanted{s.source, {}, false};
  const Known& known = known_.at(nameOf(s.source));
  const auto own = known_.find(own_);
  if (known.version > 0 || own == known_.end() || !own->second.map || !knowledge.state)
    return wanted;
  wanted.no_others = !s.index;  // index and outline are on their way
  if (!s.index || !s.outline) return wanted;
  const auto pose = poseInOwn(nameOf(s.source), known, *knowledge.state);
  if (!pose) return wanted;
  const auto outline = outlineFrom(*s.outline);
  wanted.blocks = blocksOfOverlap(*s.index, *outline, *own->second.map->map.octree(), *pose);
  if (joinedMember(nameOf(s.source), *knowledge.state)) return wanted;
  const auto is_here = [&](BlockCode code) { return s.blocks->blocks.count(code) > 0; };
  wanted.blocks.erase(std::remove_if(wanted.blocks.begin(), wanted.blocks.end(), is_here),
                      wanted.blocks.end());
  wanted.no_others = !wanted.blocks.empty();
  const size_t few = std::max<size_t>(kFewBlocks, s.index->blocks.size() / kPortions);
  const size_t here = s.blocks->blocks.size();
  if (here < few && here + wanted.blocks.size() > few) wanted.blocks.resize(few - here);
  return wanted;
}

/** Takes a map over if it is complete and new, or if much more of it has arrived.
 * \return True if the map of the team changes. */
bool TeamView::take(const MapSnapshot& s, Known& known) {
  if (!s.blocks || s.blocks->blocks.empty()) return false;
  if (s.complete_version > 0 ? s.complete_version == known.tried : known.version > 0) return false;
  const size_t bytes = bytesOf(*s.blocks);
  const double growth = known.has_joined ? kGrowthOfJoinedPart : kGrowthOfPart;
  if (s.complete_version == 0 && static_cast<double>(bytes) < growth * known.bytes) return false;
  known.bytes = bytes;
  known.tried = s.complete_version;
  const std::shared_ptr<const octomap::OcTree> tree = joinBlocks(*s.blocks);
  checkSize(nameOf(s.source), *tree);
  PreparedMap map(tree, options_.features);
  if (map.occupiedVoxels() == 0) return false;
  known.version = s.complete_version;
  known.map = RobotMap{nameOf(s.source),
                       map.withSources({{s.source.robot, s.source.map, known.version, 0}})};
  // A part has many places where it may be. The outline says where to look first. A whole map is
  // matched as others match it who have not seen the outline.
  if (known.version == 0 && known.meeting)
    known.map->guesses = {{own_, Prior::near(toPose(known.meeting->T_own_other))}};
  return true;
}

/** \exception std::runtime_error If all maps together are too large with a map. */
void TeamView::checkSize(const std::string& robot, const octomap::OcTree& map) const {
  size_t nodes = map.size();
  for (const auto& [name, known] : known_)
    if (known.map && name != robot) nodes += known.map->map.octree()->size();
  if (nodes > kMostTeamNodes) throw std::runtime_error("the maps of the team have too many nodes");
}

/** Matches the outline of a map with the map of this robot, once for each version of both. */
void TeamView::meet(const MapSnapshot& s, Known& known) {
  const auto own = known_.find(own_);
  if (own == known_.end() || !own->second.map || nameOf(s.source) == own_) return;
  if (known.version > 0 || !s.outline) return;
  const uint64_t own_version = own->second.map->map.contentHash();
  if (known.met_own == own_version && known.met_outline == *s.outline) return;
  known.met_own = own_version;
  known.met_outline = *s.outline;
  const PreparedMap outline(std::shared_ptr<const octomap::OcTree>(outlineFrom(*s.outline)),
                            options_.features);
  if (outline.occupiedVoxels() == 0) return;
  const Alignment match = align(own->second.map->map, outline, Prior::none(), options_);
  known.meeting = {nameOf(s.source), match.match.T_a_b, match.evaluation.probability,
                   s.outline->size()};
}

/** Returns the pose of another map's frame in the frame of the own map, if there is one. */
std::optional<Eigen::Isometry3d> TeamView::poseInOwn(const std::string& robot, const Known& known,
                                                     const TeamState& state) const {
  const FusionMember* own = joinedMember(own_, state);
  const FusionMember* other = joinedMember(robot, state);
  if (own && other) return toEigen(own->pose.mean).inverse() * toEigen(other->pose.mean);
  if (known.meeting) return known.meeting->T_own_other;
  return std::nullopt;
}

/** Makes the team anew, in the order of the names. */
void TeamView::rebuild() {
  team_ = std::make_unique<MapTeam>(options_);
  for (const auto& known : known_)
    if (known.second.map) team_->set(*known.second.map);
}

}  // namespace mrpt::fusion
