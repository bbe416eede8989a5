// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/many_maps.h>
#include <mrpt/fusion/voxels.h>

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/** \file
 * The findings of a run as a value. text.h and json.h print it. */

namespace mrpt::fusion {

/** A map in a report. */
struct MapReport {
  std::string role;            ///< "a", "b", "fused", "transformed", "map", or a robot's name
  std::string path;            ///< File of the map
  double resolution = 0;       ///< Voxel size, m
  double low[3] = {0, 0, 0};   ///< Lowest corner of the box of the known space, m
  double high[3] = {0, 0, 0};  ///< Highest corner of that box, m
  size_t nodes = 0;            ///< Number of nodes of the octree
  MapStatistics statistics;    ///< Voxels and entropies
  Sources sources;             ///< Sources of the map, if the file or the run knows them
};

/** Collects the figures of a map. O(nodes). */
MapReport reportOn(const std::string& role, const std::string& path, const octomap::OcTree& map);

/** Number of observations of a recording. */
struct ObservationCount {
  size_t inserted = 0;  ///< Observations that changed the map
  size_t ignored = 0;   ///< All other observations

  /** Observations of one class that were left out. */
  struct LeftOut {
    std::string kind;    ///< Class of the observations
    std::string reason;  ///< Why they were left out
    size_t count = 0;    ///< Number of observations
  };
  std::vector<LeftOut> left_out;  ///< Parts of ignored, by class and reason
};

/** A slice of a map that was written. */
struct SliceReport {
  size_t width = 0, height = 0;                ///< Number of cells along x and y
  size_t occupied = 0, free = 0, unknown = 0;  ///< Number of cells of each kind
};

/** All findings of a run. A field without a value does not apply to the command. */
struct Report {
  std::string command;                               ///< Subcommand of map-fusion
  std::vector<std::string> notes;                    ///< Differences between files and their maps
  std::vector<MapReport> maps;                       ///< Maps that were read or written, in order
  std::optional<mrpt::poses::CPose3D> initial_pose;  ///< Initial guess of T_a_b
  std::optional<mrpt::poses::CPose3DPDFGaussian> pose;    ///< T_a_b; zero covariance if not judged
  std::optional<Alignment> match;                         ///< Match of two maps, or a judged pose
  std::vector<FusionMember> members;                      ///< Robots of a team, in the order given
  std::vector<TeamPair> pairs;                            ///< Matches of all pairs of a team
  std::optional<size_t> bytes;                            ///< Size of the file that `pack` wrote
  std::optional<std::pair<Counting, Counting>> counting;  ///< How A and B count, if they are merged
  std::string policy;                            ///< Merge policy; empty: nothing was merged
  std::optional<size_t> edges;                   ///< Number of edge voxels that `edges` found
  std::optional<size_t> key_frames;              ///< Number of key frames of joined recordings
  std::optional<SliceReport> slice;              ///< Slice that `slice` wrote
  std::optional<ObservationCount> observations;  ///< Observations that `build` read
  std::vector<std::pair<std::string, double>> seconds;  ///< Wall time of each step, s, in order
};

}  // namespace mrpt::fusion
