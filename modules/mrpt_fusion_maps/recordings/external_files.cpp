// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Finds and loads the external files of recordings. */

#include "mrpt_fusion_maps/recordings/external_files.h"

#include <mrpt/io/lazy_load_path.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationStereoImages.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "fusion_base/error_text.h"

using namespace mrpt::obs;

namespace mrpt::fusion {
namespace {

/** Returns the files that load() of an observation reads. */
std::vector<std::string> externalFilesOf(const CObservation& obs) {
  std::vector<std::string> files;
  if (const auto* scan = dynamic_cast<const CObservation3DRangeScan*>(&obs)) {
    if (scan->hasPoints3D && scan->points3D_isExternallyStored())
      files.push_back(scan->points3D_getExternalStorageFileAbsolutePath());
    if (scan->hasRangeImage && scan->rangeImage_isExternallyStored())
      files.push_back(scan->rangeImage_getExternalStorageFileAbsolutePath(""));
  } else if (const auto* cloud = dynamic_cast<const CObservationPointCloud*>(&obs)) {
    if (cloud->isExternallyStored())
      files.push_back(mrpt::io::lazy_load_absolute_path(cloud->getExternalStorageFile()));
  }
  return files;
}

bool isPicture(const CObservation& obs) {
  return dynamic_cast<const CObservationImage*>(&obs) ||
         dynamic_cast<const CObservationStereoImages*>(&obs);
}

}  // namespace

std::string imagesDirectoryOf(const std::string& recording) {
  // CRawlog::detectImagesDirectory() returns the directory without the '/'.
  std::filesystem::path file(recording);
  const auto folder = std::filesystem::absolute(file).parent_path();
  if (file.extension() == ".gz") file.replace_extension();
  const auto own = folder / (file.stem().string() + "_Images");
  for (const auto& directory : {own, folder / "Images"})
    if (std::filesystem::is_directory(directory)) return directory.string() + "/";
  return folder.string() + "/";
}

void loadExternalData(const CObservation& obs) {
  if (isPicture(obs)) return;
  const auto files = externalFilesOf(obs);
  const std::string what = "the data of a " + std::string(obs.GetRuntimeClass()->className) +
                           " of '" + obs.sensorLabel + "'";
  for (const auto& file : files)  // MRPT gives no reason if a file is missing
    if (!std::ifstream(file))
      throw std::runtime_error(what + " is in the file " + file +
                               ", which cannot be opened: " + std::strerror(errno));
  try {
    obs.load();
  } catch (const std::exception& e) {
    if (files.empty()) throw;
    throw std::runtime_error(what + " cannot be loaded from the file " + files.front() + ": " +
                             messageOf(e));
  }
}

}  // namespace mrpt::fusion
