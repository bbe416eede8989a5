// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Writes slices. */

#include "slice_out.h"

#include <filesystem>

#include "fusion_base/files.h"
#include "fusion_report/navigation_map.h"
#include "mrpt_maps.h"

namespace fs = std::filesystem;

namespace map_fusion {

bool isSliceFile(const std::string& path) {
  const fs::path file(path);
  const fs::path plain = file.extension() == ".gz" ? file.stem() : file;
  return file.extension() == ".pgm" || plain.extension() == ".gridmap";
}

std::string yamlBeside(const std::string& path) {
  fs::path file(path);
  return file.extension() == ".pgm" ? file.replace_extension(".yaml").string() : std::string();
}

void saveSlice(const mrpt::fusion::MapSlice& slice, const mrpt::fusion::CellThresholds& thresholds,
               const std::string& path) {
  const std::string yaml = yamlBeside(path);
  if (yaml.empty()) return mrptMaps().saveSlice(slice, path);
  mrpt::fusion::writeFileAtomically(path, toPgm(slice, thresholds));
  mrpt::fusion::writeFileAtomically(yaml, toMapYaml(slice, fs::path(path).filename()));
}

}  // namespace map_fusion
