// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/fusion/export.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/obs/CObservationLocalMap.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

/** \file
 * Maps from files of any kind, told apart by what is in them, and from recorded observations.
 */

namespace mrpt::fusion {

/** How to make a map of recorded observations. */
struct BuildParams {
  /** Map definition as MRPT's apps read it: `<kind>_count` in \a section and the maps' own sections
   * beside it; null: one CProbOctoMap with its default options. Not owned. */
  const mrpt::config::CConfigFileBase* config = nullptr;
  std::string section = "MappingApplication";  ///< of \a config
  /** Called with the number of observations inserted so far, if given. */
  std::function<void(size_t inserted)> progress;
};

/** What buildMap() made. */
struct BuiltMap {
  /** The map; a CMultiMetricMap if the definition asks for several. */
  mrpt::maps::CMetricMap::Ptr map;
  size_t inserted = 0;  ///< observations that changed the map
  size_t ignored = 0;   ///< observations of other kinds, or out of the time of the known poses
};

/** Builds a map from a simplemap or a rawlog, gz-compressed or not.
 *
 * A simplemap brings the poses of its frames. A rawlog must have the robot's poses: in the
 * observations format as CObservationRobotPose or, if there are none, CObservationOdometry,
 * interpolated to the time of each observation; in the actions format as robot movements, which are
 * added up. Lazy-load observations are loaded from the rawlog's own images directory.
 * \exception std::runtime_error "<path>: <reason>": not such a file, truncated, no poses, a
 * definition without maps, or with some of a class that MRPT does not know.
 */
MRPT_FUSION_API BuiltMap buildMap(const std::string& path, const BuildParams& params = {});

/** Loads what map a file of any kind holds: an octree (`.ot`, `.bt`) as a mrpt::maps::CProbOctoMap,
 * an MRPT-serialized map as it is, the map that a rawlog of one robot's CObservationLocalMap brings
 * (see loadLocalMaps()), or observations to build it from (see buildMap()).
 * \exception std::runtime_error "<path>: <reason>". */
MRPT_FUSION_API mrpt::maps::CMetricMap::Ptr loadAnyMap(const std::string& path,
                                                       const BuildParams& params = {});

/** The same, for a map that asProbOctoMap() knows. */
MRPT_FUSION_API std::shared_ptr<const mrpt::maps::CProbOctoMap> loadMap(
    const std::string& path, const BuildParams& params = {});

/** The latest map of each robot in a recorded mission, a rawlog with CObservationLocalMap in it, in
 * the order in which the robots first appear; edges alone only of robots that sent no more. None if
 * there are none in the file, or it is no rawlog. \exception std::runtime_error "<path>: <reason>":
 * not readable, truncated. */
MRPT_FUSION_API std::vector<mrpt::obs::CObservationLocalMap::Ptr> loadLocalMaps(
    const std::string& path);

/** Writes a rawlog of such maps, gz-compressed if it ends in `.gz`; all of the file or nothing.
 * \exception std::runtime_error "<path>: <reason>". */
MRPT_FUSION_API void saveLocalMaps(const std::vector<mrpt::obs::CObservationLocalMap::Ptr>& maps,
                                   const std::string& path);

/** Saves any MRPT object so that all of the file is written or nothing; gz-compressed if it ends in
 * `.gz` or, as MRPT's scenes are, in `.3Dscene`. \exception std::runtime_error "<path>: <reason>".
 */
MRPT_FUSION_API void saveObject(const mrpt::serialization::CSerializable& object,
                                const std::string& path);

/** Saves a map so that all of the file is written or nothing: `.ot` and `.bt` by extension (for
 * maps that asProbOctoMap() knows), else as an MRPT-serialized object, gz-compressed if it ends in
 * `.gz`. \exception std::runtime_error "<path>: <reason>". */
MRPT_FUSION_API void saveMap(const mrpt::maps::CMetricMap& map, const std::string& path);

}  // namespace mrpt::fusion
