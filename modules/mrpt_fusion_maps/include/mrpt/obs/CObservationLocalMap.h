// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <mrpt/maps/CMetricMap.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace octomap {
class OcTree;
}

namespace mrpt::obs {

/** The map that a robot has built so far. The robot sends it to other robots or writes it to a
 * rawlog.
 *
 * CObservation::sensorLabel is the name of the robot, so that the tools of MRPT list, filter and
 * export by robot. CObservation::timestamp is the time when the map was sent. A rawlog with such
 * maps of several robots is a recorded mission.
 *
 * A CProbOctoMap is packed without loss: every log-odds value is kept bit for bit. Its size is 0.56
 * times the size of the gzipped `.ot` file or less, see #smallest. Other maps, for example a
 * CEdgeVoxelMap, serialize themselves.
 */
class MRPT_FUSION_API CObservationLocalMap : public CObservation {
  DEFINE_SERIALIZABLE(CObservationLocalMap, mrpt::obs)

 public:
  /** Creates an observation without a map, at an unknown pose: the standard deviations are 1 km and
   * 1000 rad. */
  CObservationLocalMap();

  uint64_t sequence = 0;  ///< Number of the map of this robot. The highest is the latest map
  /** Pose of the map's frame in the common frame of the mission, m and rad, with its covariance. */
  mrpt::poses::CPose3DPDFGaussian pose;
  /** The map: a CProbOctoMap or a CEdgeVoxelMap. */
  mrpt::maps::CMetricMap::Ptr map;
  /** How a CProbOctoMap is packed. False: by Zstandard. Packing and a link of 1 Mbit/s together
   * take the least time. True: by LZMA. The map has 0.9 times the bytes, and packing takes 10 times
   * as long. A map that is read keeps the packing with which it came. */
  bool smallest = false;

  /** Returns the mean of the pose: the frame of the map is the frame of the sensor. */
  void getSensorPose(mrpt::poses::CPose3D& out_sensorPose) const override;
  /** Sets the mean of the pose. */
  void setSensorPose(const mrpt::poses::CPose3D& newSensorPose) override;

  /** Describes robot, sequence, pose and map. RawLogViewer shows this text. */
  void getDescriptionAsText(std::ostream& o) const override;

  bool exportTxtSupported() const override { return true; }  ///< Returns true
  std::string exportTxtHeader() const override;              ///< Returns the names of the columns
  std::string exportTxtDataRow()
      const override;  ///< Sequence, pose (m, rad) and description of the map
};

/** What has changed in the map of a robot: what the robot sends over a thin link, see
 * doc/joining.md. `map-fusion join --record` writes such observations.
 *
 * The map is divided into blocks. A diff has the list of all blocks, and the blocks that have
 * changed. So the diffs of a robot, in their order, give its map bit for bit. A diff with all
 * blocks is a whole map: it starts anew. mrpt::maps::CProbOctoMap::insertObservation() takes the
 * diffs of one robot.
 *
 * CObservation::sensorLabel is the name of the robot. CObservation::timestamp is the time when the
 * diff was sent or had arrived. */
class MRPT_FUSION_API CObservationMapDiff : public CObservation {
  DEFINE_SERIALIZABLE(CObservationMapDiff, mrpt::obs)

 public:
  /** A block: a cube of the octree. */
  struct Block {
    uint64_t cube = 0;     ///< A leading 1, then 3 bits for each level from the root down
    uint64_t version = 0;  ///< Version of the map at which the block changed last
    std::string nodes;     ///< Compressed nodes of the cube, at most 8000 bytes
  };

  uint64_t version = 0;       ///< Version of the map
  std::string index;          ///< Compressed list of all blocks of the map
  std::vector<Block> blocks;  ///< Blocks that have changed

  void getSensorPose(
      mrpt::poses::CPose3D& out_sensorPose) const override;  ///< The frame of the map
  /** Does nothing: the frame of the map is the frame of the sensor. */
  void setSensorPose(const mrpt::poses::CPose3D& newSensorPose) override;
  /** Describes robot, version and size. RawLogViewer shows this text. */
  void getDescriptionAsText(std::ostream& o) const override;
};

}  // namespace mrpt::obs

namespace mrpt::fusion {

/** Makes the diffs of a map that grows, for a rawlog. One thread uses it at a time. */
class MRPT_FUSION_API MapDiffs {
 public:
  /** \param[in] robot Name of the robot. */
  explicit MapDiffs(const std::string& robot);
  ~MapDiffs();
  MapDiffs(const MapDiffs&) = delete;
  MapDiffs& operator=(const MapDiffs&) = delete;

  /** Returns what has changed since the last call. The first diff has the whole map. The timestamp
   * is the present time. Null if nothing has changed.
   * \param[in] map The map. It is copied.
   * \exception std::length_error If the map is too large: 65536 blocks, 64 MB.
   * Cost: one traversal, a copy, and the compression of the blocks that have changed. */
  mrpt::obs::CObservationMapDiff::Ptr next(const octomap::OcTree& map);

 private:
  class Sent;
  std::unique_ptr<Sent> m_sent;
};

}  // namespace mrpt::fusion
