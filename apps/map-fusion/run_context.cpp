// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Loads the settings of a run, shows its progress and writes its report. */

#include "run_context.h"

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/core/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <stdexcept>
#include <vector>

#include "fusion_base/error_text.h"
#include "fusion_base/files.h"
#include "fusion_base/printable.h"
#include "fusion_report/json.h"
#include "fusion_report/page/page.h"
#include "fusion_report/text.h"
#include "output.h"

namespace map_fusion {

namespace {

constexpr const char* kMatchingSection = "ProbabilisticMapMatching";

std::string toText(const mrpt::fusion::IterationRecord& i) {
  const char* level = i.level == mrpt::fusion::Level::Edge ? "edges" : "voxels";
  return mrpt::format("matching %s: %zu pairs, rms distance %.3f m, step %.4f m", level, i.pairs,
                      std::sqrt(i.mse), i.step_translation);
}

}  // namespace

RunContext::RunContext(const Arguments& arguments) : args(arguments), progress(!args.quiet) {
  report.command = args.command;
  std::vector<std::string> inputs = args.maps;
  inputs.insert(inputs.end(), {args.config, args.init, args.pose, args.priors});
  for (const auto& path : outputsOf(args)) {
    checkWritable(path, inputs);
    if (std::filesystem::is_regular_file(path)) old_files_.push_back(path);
  }
  if (!args.config.empty()) mrpt::fusion::withPath(args.config, [this] { loadConfig(); });
  if (args.full_6dof) options.search.rotations = mrpt::fusion::SearchRotations::All;
  on_iteration = [this](const mrpt::fusion::IterationRecord& i) {
    if (args.verbose)
      std::cerr << toText(i) << "\n";
    else
      progress.show(toText(i));
  };
  const bool writes_map = !args.output.empty() && args.command != "pack" && args.command != "slice";
  if (writes_map && mapExtensionOf(args.output) == MapExtension::Unknown)
    note(args.output + ": is written as an object of MRPT, for which .gridmap is usual");
  startStep();
}

RunContext::~RunContext() = default;

void RunContext::loadConfig() {
  // Not by MRPT, for which a missing file is an empty file. A pipe can be read only once.
  constexpr size_t kMostBytes = size_t{16} << 20U;
  config_ = std::make_unique<mrpt::config::CConfigFileMemory>();
  config_->setContent(mrpt::fusion::readFileBytes(args.config, kMostBytes));
  const bool has_map = config_->sectionExists(args.section);
  const bool has_matching = config_->sectionExists(kMatchingSection);
  if (!has_map && !has_matching)
    throw std::runtime_error("has neither a section [" + std::string(kMatchingSection) +
                             "] nor a section [" + args.section + "]");
  if (has_matching) options.loadFromConfigFile(*config_, kMatchingSection);
}

MapDefinition RunContext::mapDefinition() {
  MapDefinition definition;
  if (config_ && config_->sectionExists(args.section)) definition.config = config_.get();
  definition.section = args.section;
  definition.progress = [this](size_t n) {
    progress.show("building: " + std::to_string(n) + " observations");
  };
  return definition;
}

void RunContext::note(const std::string& text) {
  progress.clear();
  std::cerr << "map-fusion: note: " << mrpt::fusion::printable(text) << "\n";
  report.notes.push_back(text);
}

void RunContext::write(const std::string& path, const std::string& bytes) {
  mrpt::fusion::writeFileAtomically(path, bytes);
  wrote(path);
}

void RunContext::wrote(const std::string& path) {
  if (std::find(written_.begin(), written_.end(), path) == written_.end()) written_.push_back(path);
}

void RunContext::endStep(const std::string& name) {
  auto& seconds = report.seconds;
  const double elapsed = clock_.Tac();
  const auto known = std::find_if(seconds.begin(), seconds.end(),
                                  [&](const auto& step) { return step.first == name; });
  if (known != seconds.end())
    known->second += elapsed;
  else
    seconds.emplace_back(name, elapsed);
  startStep();
}

void RunContext::noteUnusedOptions() {
  if (args.resolution > 0 && !uses_resolution)
    note("--resolution has no effect: each map states its voxel size");
  if (!args.sensor_origin.empty() && !uses_sensor_origin)
    note("--sensor-origin has no effect: no map is a point cloud");
}

void RunContext::finish() {
  noteUnusedOptions();
  const auto outputs = outputsOf(args);
  const bool is_stdout_taken = std::any_of(outputs.begin(), outputs.end(), isStandardOutput);
  std::ostream& summary = is_stdout_taken ? std::cerr : std::cout;
  if (!args.quiet) mrpt::fusion::print(report, summary);
  saveReports();
  if (!args.quiet) printWritten(summary);
}

void RunContext::saveReports() {
  if (!args.json.empty()) write(args.json, mrpt::fusion::toJson(report));
  if (!args.page.empty() && !page_scene.empty())
    write(args.page, mrpt::fusion::toPage(report, page_scene));
}

void RunContext::printWritten(std::ostream& out) const {
  std::string label = "written";
  for (const std::string& path : written_) {
    if (isStandardOutput(path)) continue;
    const bool is_old = std::find(old_files_.begin(), old_files_.end(), path) != old_files_.end();
    out << std::left << std::setw(mrpt::fusion::kValueColumn) << label
        << mrpt::fusion::printable(path) << (is_old ? " (replaced)" : "") << "\n";
    label.clear();
  }
}

}  // namespace map_fusion
