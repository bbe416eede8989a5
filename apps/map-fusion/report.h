// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/many_maps.h>
#include <mrpt/fusion/voxels.h>

#include <iosfwd>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/** A map in a report. */
struct MapReport {
  std::string role;  ///< "a", "b", "fused", "map", or the robot's name
  std::string path;
  double resolution = 0;                           ///< m
  double low[3] = {0, 0, 0}, high[3] = {0, 0, 0};  ///< box of the known space, m
  size_t nodes = 0;
  mrpt::fusion::MapStatistics statistics;
};
MapReport reportOn(const std::string& role, const std::string& path, const octomap::OcTree& map);

/** Everything that a run found out: printed for people, written as JSON for programs
 * (doc/report.schema.json). */
struct Report {
  std::string command;
  std::vector<MapReport> maps;
  std::optional<mrpt::poses::CPose3D> initial_pose;
  std::optional<mrpt::poses::CPose3DPDFGaussian> pose;  ///< covariance zero if not judged
  std::optional<mrpt::fusion::Alignment> match;
  std::vector<mrpt::fusion::FusionMember> members;        ///< of a fusion of many maps
  std::optional<size_t> bytes;                            ///< written by `pack`
  std::string policy;                                     ///< of the merge, if there was one
  std::optional<size_t> edges;                            ///< edge voxels found by `edges`
  std::optional<std::pair<size_t, size_t>> observations;  ///< inserted, ignored by `build`
  std::vector<std::pair<std::string, double>> seconds;    ///< wall time of each step, in order
};

void print(const Report& report, std::ostream& out);
std::string toJson(const Report& report);
