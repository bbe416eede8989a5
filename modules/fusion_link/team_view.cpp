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

/** A part of a map is fused anew when its bytes have grown by this factor. */
constexpr double kGrowthOfPart = 1.25;

/** Largest number of nodes of all maps of a team: 20 large buildings, and about 1 GB. */
constexpr size_t kMostTeamNodes = 20'000'000;

std::string nameOf(const SourceName& source) {
  return source.map.empty() ? source.robot : source.robot + "/" + source.map;
}

size_t bytesOf(const MapBlocks& blocks) {
  size_t bytes = 0;
  for (const auto& block : blocks.blocks) bytes += block.second->size();
  return bytes;
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
  for (const MapSnapshot& s : snapshots) {
    const std::string name = nameOf(s.source);
    try {
      if (take(s, known_[name])) changed.push_back(name);
    } catch (const std::exception& e) {
      result.notes.push_back(name + ": " + messageOf(e));
    }
  }
  for (const std::string& name : changed) team_->set(*known_[name].map);
  if (const auto robots = team_->robots(); !std::is_sorted(robots.begin(), robots.end())) rebuild();
  for (const MapSnapshot& s : snapshots) {
    const std::string name = nameOf(s.source);
    try {
      meet(s, known_[name]);
    } catch (const std::exception& e) {
      result.notes.push_back(name + ": " + messageOf(e));
    }
  }
  try {
    result.state = team_->state();
  } catch (const std::exception& e) {
    result.notes.push_back(messageOf(e));
    return result;
  }
  for (const FusionMember& member : result.state->members) {
    const Known& known = known_.at(member.robot);
    result.maps.push_back(*known.map);
    result.whole_maps += known.version > 0 ? 1 : 0;
    if (known.version == 0) result.parts[member.robot] = known.bytes;
  }
  for (const MapSnapshot& s : snapshots) {
    const std::string name = nameOf(s.source);
    const Known& known = known_.at(name);
    if (known.version > 0 || !s.index || !s.outline || name == own_) continue;
    if (known.meeting) result.meetings.push_back(*known.meeting);
    const auto pose = poseInOwn(name, known, *result.state);
    if (!pose) continue;
    try {
      const auto outline = outlineFrom(*s.outline);
      const octomap::OcTree& own = *known_.at(own_).map->map.octree();
      result.wanted.push_back({s.source, blocksOfOverlap(*s.index, *outline, own, *pose)});
    } catch (const std::exception& e) {
      result.notes.push_back(name + ": " + messageOf(e));
    }
  }
  return result;
}

/** Takes a map over if it is complete and new, or if much more of it has arrived.
 * \return True if the map of the team changes. */
bool TeamView::take(const MapSnapshot& s, Known& known) {
  if (!s.blocks || s.blocks->blocks.empty()) return false;
  if (s.complete_version > 0 ? s.complete_version == known.tried : known.version > 0) return false;
  const size_t bytes = bytesOf(*s.blocks);
  if (s.complete_version == 0 && static_cast<double>(bytes) < kGrowthOfPart * known.bytes)
    return false;
  known.bytes = bytes;
  known.tried = s.complete_version;
  const std::shared_ptr<const octomap::OcTree> tree = joinBlocks(*s.blocks);
  checkSize(nameOf(s.source), *tree);
  PreparedMap map(tree, options_.features);
  if (map.occupiedVoxels() == 0) return false;
  known.version = s.complete_version;
  known.map = RobotMap{nameOf(s.source),
                       map.withSources({{s.source.robot, s.source.map, known.version, 0}})};
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
  const auto member = [&](const std::string& name) {
    return std::find_if(state.members.begin(), state.members.end(),
                        [&](const FusionMember& m) { return m.robot == name && m.joined; });
  };
  const auto own = member(own_), other = member(robot);
  if (own == state.members.end()) return std::nullopt;
  if (other != state.members.end())
    return toEigen(own->pose.mean).inverse() * toEigen(other->pose.mean);
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
