// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

/** What the command line asks for; each subcommand uses its part. */
struct Arguments {
  std::string command;
  std::vector<std::string> maps;   ///< input files: A, B...
  std::string init, pose;          ///< POSE
  bool full_6dof = false;          ///< the maps have no common vertical
  std::vector<double> init_sigma;  ///< m, deg; empty: as configured
  std::string output;              ///< map or point cloud
  std::string pose_out, picture, scene, json;
  std::string config, section = "MappingApplication";
  std::string policy;     ///< empty: as configured
  double resolution = 0;  ///< m; 0: that of the input
  bool edges_only = false;
  bool force = false, quiet = false, verbose = false;
};

/** Documented exit codes. */
enum ExitCode { kDone = 0, kFailure = 1, kUsage = 2, kRejected = 3 };

/** Runs one subcommand. \return kDone or kRejected. \exception std::exception With one line that
 * says what went wrong and where: kFailure. */
int run(const Arguments& arguments);
