// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Makes names of external files absolute. */

#include "mrpt_fusion_maps/recordings/external_links.h"

#include <mrpt/img/CImage.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRGBD360.h>
#include <mrpt/obs/CObservationStereoImages.h>

#include <filesystem>

using namespace mrpt::obs;
using mrpt::img::CImage;

namespace mrpt::fusion {
namespace {

/** Access to the protected names of external files. MRPT's setters also write the files. */
struct PointCloudAccess : CObservationPointCloud {
  static std::string& file(CObservationPointCloud& obs) {
    return obs.*(&PointCloudAccess::m_external_file);
  }
};
struct RangeScanAccess : CObservation3DRangeScan {
  static std::string& points(CObservation3DRangeScan& obs) {
    return obs.*(&RangeScanAccess::m_points3D_external_file);
  }
  static std::string& ranges(CObservation3DRangeScan& obs) {
    return obs.*(&RangeScanAccess::m_rangeImage_external_file);
  }
};

/** CObservationRGBD360 has no functions that read these fields. */
struct Rgbd360Access : CObservationRGBD360 {
  static std::string& points(CObservationRGBD360& obs) {
    return obs.*(&Rgbd360Access::m_points3D_external_file);
  }
  static std::string& ranges(CObservationRGBD360& obs) {
    return obs.*(&Rgbd360Access::m_rangeImage_external_file);
  }
};

/** Makes names absolute. A name that is empty is not used. */
class Names {
 public:
  explicit Names(const std::string& directory) : directory_(directory) {}

  void makeAbsolute(std::string& file) const {
    if (!file.empty() && std::filesystem::path(file).is_relative()) file = directory_ + file;
  }
  void makeAbsolute(CImage& image) const {
    if (!image.isExternallyStored()) return;
    std::string file = image.getExternalStorageFile();
    makeAbsolute(file);
    image.setExternalStorage(file);
  }
  void makeAbsolute(CObservation3DRangeScan& scan) const {
    makeAbsolute(RangeScanAccess::points(scan));
    makeAbsolute(RangeScanAccess::ranges(scan));
    makeAbsolute(scan.intensityImage);
    makeAbsolute(scan.confidenceImage);
  }

 private:
  const std::string& directory_;
};

}  // namespace

void makeExternalNamesAbsolute(CObservation& obs, const std::string& directory) {
  const Names names(directory);
  if (auto* scan = dynamic_cast<CObservation3DRangeScan*>(&obs)) {
    names.makeAbsolute(*scan);
  } else if (auto* cloud = dynamic_cast<CObservationPointCloud*>(&obs)) {
    names.makeAbsolute(PointCloudAccess::file(*cloud));
  } else if (auto* picture = dynamic_cast<CObservationImage*>(&obs)) {
    names.makeAbsolute(picture->image);
  } else if (auto* stereo = dynamic_cast<CObservationStereoImages*>(&obs)) {
    names.makeAbsolute(stereo->imageLeft);
    names.makeAbsolute(stereo->imageRight);
    names.makeAbsolute(stereo->imageDisparity);
  } else if (auto* ring = dynamic_cast<CObservationRGBD360*>(&obs)) {
    names.makeAbsolute(Rgbd360Access::points(*ring));
    names.makeAbsolute(Rgbd360Access::ranges(*ring));
    for (auto& image : ring->intensityImages) names.makeAbsolute(image);
  }
}

}  // namespace mrpt::fusion
