// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

/** \file
 * The arguments of the command line. */

namespace map_fusion {

/** The arguments of a run. Each subcommand uses a part of them. */
struct Arguments {
  std::string command;             ///< Name of the subcommand
  std::vector<std::string> maps;   ///< Input files: A, B, ...
  std::string init;                ///< Initial guess, see parsePose(); empty: none
  std::vector<double> init_sigma;  ///< Standard deviations of the guess, m and deg; may be empty
  bool full_6dof = false;          ///< The maps have no common vertical
  std::string pose;                ///< Given pose of B in A, see parsePose()
  std::vector<double> heights;     ///< Lowest and highest height of a slice, m; empty: all heights
  std::vector<double> thresholds;  ///< Probabilities below which a cell is free, and from which on
                                   ///< it is occupied; empty: as the map says
  std::string output;              ///< File of the resulting map or point cloud
  std::string pose_out;            ///< File of the estimated pose; empty: none
  std::string poses_out;           ///< File of the poses of all placed robots; empty: none
  std::string priors;              ///< g2o file with guesses; empty: none
  std::string picture;             ///< PNG file of both maps; empty: none
  std::string scene;               ///< File of the 3-D scene; empty: none
  std::string page;                ///< HTML file of the report as a page; empty: none
  std::string json;                ///< File of the report as JSON; empty: none
  std::string config;              ///< Settings file; empty: defaults
  std::string section = "MappingApplication";  ///< Section of config with the map definition
  std::string policy;                          ///< Merge policy; empty: as in the settings
  std::string robot;                           ///< Name of the robot that joins a team
  unsigned domain = 0;                         ///< Number of the domain of the team
  std::vector<std::string> peers;              ///< Addresses of other robots; empty: they are found
  std::string journal;                         ///< Folder of the journal; empty: none
  std::string recording;                       ///< Rawlog of a team that is recorded; empty: none
  double seconds = 0;         ///< Time after which a robot leaves its team, s; 0: never
  size_t until_complete = 0;  ///< Number of whole maps with which a robot leaves; 0: never
  double resolution = 0;      ///< Voxel size, m; 0: as in the input. Nodes
                              ///< without a header have no other voxel size,
                              ///< point clouds have 0.1 m
  std::string sensor_origin;  ///< Position of the sensor of point clouds, see
                              ///< parsePoint(); empty: as the file states it
  unsigned threads = 0;       ///< Number of threads; 0: all cores
  bool edges_only = false;    ///< Write structural edges, not maps
  bool independent = false;   ///< Maps with the same sources all count
  bool smallest = false;      ///< Pack maps as small as possible
  bool force = false;         ///< Merge rejected matches, too
  bool quiet = false;         ///< Print neither summary nor progress
  bool verbose = false;       ///< Print each iteration
};

/** Returns the output files of the arguments. */
std::vector<std::string> outputsOf(const Arguments& args);

/** Wrong usage that only the files show. */
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/** Exit codes of the program. They are documented in --help. */
enum ExitCode { kDone = 0, kFailure = 1, kUsage = 2, kRejected = 3 };

/** Parses the command line. Prints help and usage errors. \return The exit code if there is nothing
 * to run, otherwise nothing. */
std::optional<ExitCode> parseArguments(int argc, char** argv, Arguments& args);

}  // namespace map_fusion
