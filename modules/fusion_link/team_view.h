// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/many_maps.h>
#include <mrpt/fusion/options.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fusion_link/map_replica.h"
#include "fusion_link/statements.h"

/** \file
 * What a robot makes of the maps that it has received. */

namespace mrpt::fusion {

/** What a robot has of one map at a moment. The bytes of blocks are shared. */
struct MapSnapshot {
  SourceName source;                   ///< Name of the map
  uint64_t complete_version = 0;       ///< See MapReplica
  std::optional<MapIndex> index;       ///< See MapReplica
  std::optional<MapBlocks> blocks;     ///< See MapReplica
  std::optional<std::string> outline;  ///< See MapReplica

  explicit MapSnapshot(const MapReplica& map);
};

/** Where another robot is, as far as the outline of its map says. */
struct Meeting {
  std::string robot;              ///< Name of the other robot
  Eigen::Isometry3d T_own_other;  ///< Pose of its map's frame in the frame of the own map
  double probability = 0;         ///< Probability that the pose is right, [0,1]
  size_t bytes = 0;               ///< Bytes of the outline
};

/** What a robot knows of its team. */
struct TeamKnowledge {
  std::shared_ptr<const TeamState>
      state;                            ///< Fused map and members; its map is null if there is none
  std::vector<RobotMap> maps;           ///< Maps of the state, in the order of its members
  std::vector<Meeting> meetings;        ///< Robots of which only the outline is known
  std::vector<WantedBlocks> wanted;     ///< What is wanted of each other map
  std::vector<std::string> notes;       ///< What went wrong
  std::map<std::string, size_t> parts;  ///< Bytes of the maps of the state that are not whole
  size_t whole_maps = 0;                ///< Number of maps that are in the state as a whole
};

/** Fuses the maps of a team as they arrive.
 *
 * The maps are in the order of the names of their robots. So all robots that have the same maps
 * have the same fused map, bit for bit, in the frame of the first robot by name. It is that of
 * fuseMaps() with the maps in this order.
 *
 * A map of which only some blocks have arrived is fused as far as it is known. The outline says
 * where it may be, and which blocks overlap with the own map. A few of these are wanted
 * first, and others when the part has joined. An older version that is complete stays until the
 * newer version is complete. */
class TeamView {
 public:
  /** \param[in] own Name of this robot; its map, if it has one, is the reference of meetings.
   * \param[in] options Parameters of all stages. */
  TeamView(std::string own, Options options)
      : own_(std::move(own)),
        options_(std::move(options)),
        team_(std::make_unique<MapTeam>(options_)) {}

  /** Returns what follows from the maps at a moment. Cost: see MapTeam::state(). */
  TeamKnowledge update(const std::vector<MapSnapshot>& snapshots);

 private:
  struct Known {
    uint64_t version = 0;         // complete version in the team; 0: a part, or nothing
    uint64_t tried = 0;           // complete version that was taken over or refused
    size_t bytes = 0;             // of the blocks of the part
    std::optional<RobotMap> map;  // in the team
    bool has_joined = false;
    uint64_t met_own = 0;  // versions of the own map and of the outline of the meeting
    std::string met_outline;
    std::optional<Meeting> meeting;
  };

  bool take(const MapSnapshot& snapshot, Known& known);
  void checkSize(const std::string& robot, const octomap::OcTree& map) const;
  void meet(const MapSnapshot& snapshot, Known& known);
  std::optional<Eigen::Isometry3d> poseInOwn(const std::string& robot, const Known& known,
                                             const TeamState& state) const;
  WantedBlocks wantedOf(const MapSnapshot& snapshot, const TeamKnowledge& knowledge) const;
  void rebuild();

  std::string own_;
  Options options_;
  std::map<std::string, Known> known_;  // by the name of the robot
  std::unique_ptr<MapTeam> team_;
};

}  // namespace mrpt::fusion
