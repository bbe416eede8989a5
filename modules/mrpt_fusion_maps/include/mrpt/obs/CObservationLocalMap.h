// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <mrpt/maps/CMetricMap.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <cstdint>
#include <string>

namespace mrpt::obs {

/** The map that one robot has made so far, as it sends it to others or into a rawlog.
 *
 * CObservation::sensorLabel is the robot's name, so that MRPT's tools list, filter and export by
 * robot; CObservation::timestamp is when the map was sent. A rawlog of these from several robots is
 * a recorded mission.
 *
 * A CProbOctoMap travels compressed (LZMA, see compressNodes()), every log-odds bit for bit, in
 * about half of what gzip makes of its `.ot`; other maps (a CEdgeVoxelMap) as they serialize
 * themselves.
 */
class MRPT_FUSION_API CObservationLocalMap : public CObservation {
  DEFINE_SERIALIZABLE(CObservationLocalMap, mrpt::obs)

 public:
  /** At first nothing is known of where the map is: standard deviations of 1 km (and rad). */
  CObservationLocalMap();

  uint64_t sequence = 0;  ///< of this robot's maps: the highest is the latest, and holds the rest
  /** Pose of the map's frame in the mission's common frame (m, rad), and how well it is known. */
  mrpt::poses::CPose3DPDFGaussian pose;
  /** The map: a CProbOctoMap, or a CEdgeVoxelMap. Shared with whoever else holds it. */
  mrpt::maps::CMetricMap::Ptr map;

  /** The mean of pose, the map's frame being the sensor's. */
  void getSensorPose(mrpt::poses::CPose3D& out_sensorPose) const override;
  /** Sets the mean of pose. */
  void setSensorPose(const mrpt::poses::CPose3D& newSensorPose) override;

  /** Robot, sequence, pose and what the map is: what RawLogViewer shows. */
  void getDescriptionAsText(std::ostream& o) const override;

  bool exportTxtSupported() const override { return true; }  ///< Yes
  std::string exportTxtHeader() const override;              ///< Names of the columns
  std::string exportTxtDataRow() const override;  ///< Sequence, pose (m, rad), what the map is
};

}  // namespace mrpt::obs
