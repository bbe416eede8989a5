// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/many_maps.h>

#include <Eigen/Geometry>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "fusion_team/pairs/pair_matches.h"

/** \file
 * A mission of simulated robots whose poses are known, and false matches between its maps. */

namespace mrpt::fusion::benchmark {

/** The maps of a mission. */
struct TeamMission {
  std::string name;            ///< Name of the folder
  std::vector<RobotMap> maps;  ///< Robots of the mission, then strangers
  /** Pose of the world in the frame of each map, see worldPoseTruth(); none for strangers. */
  std::vector<std::optional<Eigen::Isometry3d>> T_map_w;

  /** Returns the true pose of a map in the frame of the first map; none for strangers. */
  std::optional<Eigen::Isometry3d> truth(size_t k) const;
};

/** Reads robot_I.ot with T_robot_I_w.txt, and stranger_I.ot, for I = 0, 1, ...
 * \exception std::runtime_error What is missing or wrong, and where. */
TeamMission loadTeamMission(const std::string& folder, const FeatureParams& features);

/** False matches that are added to a mission. */
struct FalseEdges {
  double share = 0;           ///< Number of false matches over the number of pairs
  double bay = 4;             ///< Shift by a bay, m
  double probability = 0.99;  ///< Probability that each false match claims
};

/** Makes some matches false, and sure of it. The own hypotheses of the pairs stay behind the false
 * ones. Every second false match is a shift by a bay: those of one map agree with each other. All
 * others are poses at random.
 * \param[in,out] matches The matches of all pairs. */
void addFalseEdges(const TeamMission& mission, const FalseEdges& edges, std::mt19937& generator,
                   std::vector<PairMatch>& matches);

/** Places the maps as before teams: the map with the most probable match with a placed map is
 * placed next. \param[in] even_rejected If false, accepted matches count only; if true, the result
 * is the spanning tree of the most probable matches. \return The pose of each placed map in the
 * frame of the first map. */
std::vector<std::optional<Eigen::Isometry3d>> grownByMatches(size_t n,
                                                             const std::vector<PairMatch>& matches,
                                                             bool even_rejected);

}  // namespace mrpt::fusion::benchmark
