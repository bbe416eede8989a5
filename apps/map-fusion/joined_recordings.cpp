// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Joins the recordings of a run. */

#include "joined_recordings.h"

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "fusion_base/error_text.h"
#include "fusion_base/file_kind.h"
#include "fusion_base/files.h"
#include "inputs.h"
#include "mrpt_maps.h"

using mrpt::fusion::Counting;

namespace map_fusion {
namespace {

bool adds(Counting counting) {
  return counting == Counting::All || counting == Counting::UnknownSpace;
}

/** True if a file begins as a simplemap of any version of MRPT. */
bool isSimpleMap(const std::string& beginning) {
  return mrpt::fusion::beginsWithObject(beginning, "CSimpleMap") ||
         mrpt::fusion::beginsWithObject(beginning, "CSensFrameProbSequence");
}

/** Returns the recordings of two maps with the pose of the report. */
std::vector<PlacedRecording> placedPair(const RunContext& run) {
  const auto& paths = run.args.maps;
  std::vector<PlacedRecording> placed;
  if (adds(run.report.counting->first)) placed.push_back({paths[0], {}});
  if (adds(run.report.counting->second)) placed.push_back({paths[1], *run.report.pose});
  return placed;
}

/** Returns the recordings of the members that have joined. */
std::vector<PlacedRecording> placedTeam(const RunContext& run) {
  std::vector<PlacedRecording> placed;
  const auto& members = run.report.members;
  const std::vector<std::string> paths = distinctFiles(run.args.maps);
  for (size_t i = 0; i < members.size(); i++)
    if (members[i].joined && adds(members[i].counting))
      placed.push_back(
          {paths[i], members[i].hasMatch() ? members[i].pose : mrpt::poses::CPose3DPDFGaussian()});
  return placed;
}

}  // namespace

bool writesRecording(const Arguments& args) {
  return std::filesystem::path(args.output).extension() == ".simplemap";
}

void checkRecordings(const RunContext& run) {
  if (!writesRecording(run.args)) return;
  for (const auto& path : run.args.maps)
    mrpt::fusion::withPath(path, [&] {
      if (!isSimpleMap(mrpt::fusion::beginningOf(path)))
        throw std::runtime_error("is not a simplemap, and " + run.args.output +
                                 " joins the key frames of simplemaps");
    });
}

void joinRecordings(RunContext& run) {
  const auto placed = run.report.members.empty() ? placedPair(run) : placedTeam(run);
  run.report.key_frames = mrptMaps().joinRecordings(placed, run.args.output);
}

}  // namespace map_fusion
