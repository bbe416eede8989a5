// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/alignment.h>
#include <mrpt/fusion/options.h>
#include <mrpt/system/CTicTac.h>

#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "arguments.h"
#include "fusion_report/report.h"
#include "mrpt_maps.h"
#include "output.h"

namespace mrpt::config {
class CConfigFileMemory;
}

/** \file
 * What all subcommands share: settings, progress, timing and the report. */

namespace map_fusion {

/** The context of one run. */
class RunContext {
 public:
  /** Checks that the outputs can be written, and loads the settings. \exception std::exception With
   * one line that names the file. */
  explicit RunContext(const Arguments& arguments);
  RunContext(const RunContext&) = delete;
  RunContext& operator=(const RunContext&) = delete;
  ~RunContext();

  const Arguments& args;
  mrpt::fusion::Options options;           ///< Settings, with the arguments applied
  mrpt::fusion::Report report;             ///< Findings so far
  Progress progress;                       ///< Line on the terminal
  mrpt::fusion::OnIteration on_iteration;  ///< Shows an iteration
  std::string page_scene;                  ///< Picture of the page, see mrpt::fusion::toSceneJson()
  bool uses_resolution = false;            ///< True if `--resolution` had an effect
  bool uses_sensor_origin = false;         ///< True if `--sensor-origin` had an effect

  /** The map that `--config` defines. It is valid as long as this context. */
  MapDefinition mapDefinition();

  /** Tells the user what a run did not take over from a file: on stderr, and in the report. */
  void note(const std::string& text);

  /** Writes an output file, see mrpt::fusion::writeFileAtomically(). */
  void write(const std::string& path, const std::string& bytes);
  /** Remembers that an output file is written: finish() says so. */
  void wrote(const std::string& path);

  /** Starts to measure a step. */
  void startStep() { clock_.Tic(); }
  /** Adds the time since the last step to the report, and starts to measure the next step. */
  void endStep(const std::string& name);

  /** Prints the report, and writes it, see saveReports(). */
  void finish();
  /** Writes the report as JSON and as a page if wanted. */
  void saveReports();

 private:
  void loadConfig();
  void noteUnusedOptions();
  void printWritten(std::ostream& out) const;

  std::unique_ptr<mrpt::config::CConfigFileMemory> config_;
  mrpt::system::CTicTac clock_;
  std::vector<std::string> old_files_;  // outputs that exist before the run
  std::vector<std::string> written_;    // outputs that are written
};

}  // namespace map_fusion
