// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/serialization/CSerializable.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "mrpt_fusion_maps/missions.h"
#include "mrpt_fusion_maps/recordings/object_reader.h"
#include "mrpt_fusion_maps/recordings/robot_path.h"

/** \file
 * A recording that is read once.
 */

namespace mrpt::fusion {

/** The objects of a recording. The constructor reads the whole file, because the last pose of the
 * robot may place the first observation. The objects are kept up to 256 MB. Of larger recordings
 * the objects are read again, while the objects before them are used. */
class Recording {
 public:
  static constexpr uint64_t kMostKeptBytes = uint64_t{1} << 28U;  ///< Size of a kept recording

  /** Reads a recording to its end. \param[in] path The file. \param[in,out] reader The file, after
   * its first object. \param[in] first The first object. \param[in] most_kept_bytes Size up
   * to which the objects are kept. \exception std::runtime_error If the file
   * is damaged. */
  Recording(std::string path, ObjectReader& reader, mrpt::serialization::CSerializable::Ptr first,
            uint64_t most_kept_bytes = kMostKeptBytes);

  /** Returns the path of the robot. */
  const RobotPath& robotPath() const { return path_; }
  /** Returns the maps of robots in the recording. */
  const LatestMaps& latestMaps() const { return maps_; }
  /** Calls \a f for each object in the order of the file. Can be called once: the objects are
   * freed.
   */
  void forEachObject(const std::function<void(const mrpt::serialization::CSerializable&)>& f);

 private:
  void add(const mrpt::serialization::CSerializable::Ptr& object);

  std::string file_;
  RobotPath path_;
  LatestMaps maps_;
  bool all_kept_ = true;
  std::vector<mrpt::serialization::CSerializable::Ptr> objects_;
};

}  // namespace mrpt::fusion
