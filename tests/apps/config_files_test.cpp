// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests that the installed settings files hold the parameters of the code. */

#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/slam/CProbabilisticMapMatching.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

namespace {

using Options = mrpt::slam::CProbabilisticMapMatching::TConfigParams;

std::string toIni(const Options& options, const std::string& header) {
  mrpt::config::CConfigFileMemory config;
  options.saveToConfigFile(config, "ProbabilisticMapMatching");
  std::string text;
  config.getContent(text);
  return header + text;
}

/** Returns the options of the published algorithm: all voxels, walks in all directions, no search,
 * pairs of points, constant gates, the statistical test only, the relative-entropy filter. */
Options paperOptions() {
  Options o;
  o.features.scale.fixed = 1;
  o.features.edges.min_surface_variation = 0;
  o.features.edges.trace_window = M_PI / 2;
  o.evaluation.voxels = 0;
  o.features.voxel_spacing = 0;
  o.features.edge_spacing = 0;
  o.search.translation = 0;
  o.registration.voxel_metric = mrpt::fusion::VoxelMetric::Point;
  o.registration.edge_level.final_gate = o.registration.edge_level.gate;
  o.registration.voxel_level.final_gate = o.registration.voxel_level.gate;
  o.registration.solver.max_steps = 10;
  o.evaluation.max_free_conflict = 1;
  o.evaluation.max_runner_up = 1;
  o.evaluation.min_probability = 0;
  o.evaluation.sure_probability = 0;
  o.evaluation.min_overlap = 0;
  o.merge.policy = mrpt::fusion::MergePolicy::RelativeEntropy;
  return o;
}

/** Expects the contents of a settings file. Writes the file if UPDATE_CONFIG_FILES is set. */
void expectFile(const std::string& name, const std::string& contents) {
  const std::string path = std::string(CONFIG_DIR) + "/" + name;
  if (std::getenv("UPDATE_CONFIG_FILES")) std::ofstream(path) << contents;
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), contents) << "run with UPDATE_CONFIG_FILES=1 to write it anew";
}

TEST(ConfigFiles, HoldTheDefaults) {
  expectFile("pmm.ini", toIni(Options(),
                              "# mrpt-fusion's defaults. For map-fusion --config and "
                              "CProbabilisticMapMatching::options.\n"));
}

TEST(ConfigFiles, HoldThePublishedAlgorithm) {
  expectFile(
      "pmm_paper.ini",
      toIni(paperOptions(),
            "# Two-level probabilistic map matching as published (Yue et al.), with Table I's "
            "parameters.\n"));
}

TEST(ConfigFiles, HoldTheVerdictsModel) {
  mrpt::config::CConfigFileMemory config;
  mrpt::fusion::saveVerdictModel(mrpt::fusion::VerdictModel(), config);
  std::string text;
  config.getContent(text);
  expectFile("verdict_model.ini",
             "# The verdict's model, fitted by scripts/fit_verdict.py. Copy the section into a "
             "settings file to change it.\n" +
                 text);
}

TEST(ConfigFiles, LoadAgain) {
  const mrpt::config::CConfigFileMemory config(toIni(paperOptions(), ""));
  Options o;
  o.loadFromConfigFile(config, "ProbabilisticMapMatching");
  EXPECT_EQ(toIni(o, ""), toIni(paperOptions(), ""));
}

}  // namespace
