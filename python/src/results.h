// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/alignment.h>
#include <mrpt/fusion/many_maps.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "map.h"

/** \file
 * Results in Python. They keep the maps that they are about, for pages. */

namespace mrpt_fusion_python {

/** The match of two maps, or a judged pose. */
struct Match {
  const char* command = "match";  ///< Command of map-fusion that does the same
  MapPtr a, b;
  Settings settings;
  std::optional<mrpt::poses::CPose3D> guess = {};
  mrpt::fusion::Alignment alignment = {};
};

/** Two maps, merged. */
struct Merged {
  MapPtr map;
  std::pair<mrpt::fusion::Counting, mrpt::fusion::Counting> counting;  ///< How A and B count
};

/** A robot and its map. */
struct Robot {
  std::string name;
  MapPtr map;
};

/** The fusion of two maps, or of the maps of a team. */
struct Fusion {
  std::vector<Robot> robots;
  Settings settings;
  MapPtr map;                         ///< Fused map; null if nothing was merged
  std::optional<Match> match = {};    ///< Match of two maps
  std::optional<Merged> merged = {};  ///< Result of two maps, if they are merged
  std::vector<mrpt::fusion::FusionMember> members =
      {};                                          ///< Results of a team, in the order of robots
  std::vector<mrpt::fusion::TeamPair> pairs = {};  ///< Matches of all pairs of a team

  /** Returns whether all maps are in the fused map, except those that are edges alone. */
  bool isAccepted() const;
};

/** Merges two maps. \param[in] is_given See mrpt::fusion::mergeSources(). */
Merged mergePair(const Map& a, const Map& b, const Eigen::Isometry3d& T_a_b,
                 const Settings& settings, bool is_given);

/** Matches two maps. */
Match matchPair(MapPtr a, MapPtr b, const mrpt::fusion::Prior& prior, const Settings& settings);

}  // namespace mrpt_fusion_python
