// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/maps/CProbOctoMap.h>

#include <functional>
#include <memory>
#include <string>

/** \file
 * Maps from files of any kind, told apart by what is in them, and from recorded observations.
 */

namespace mrpt::maps {

/** The probabilistic octomap that a map is, holds or converts to: a CProbOctoMap, a COctoMap
 * (converted), or the first of these in a CMultiMetricMap. Not a copy where none is needed: the
 * result is then only valid as long as \a map. Null if there is none. */
std::shared_ptr<const CProbOctoMap> asProbOctoMap(const CMetricMap& map);

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
  CMetricMap::Ptr map;
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
 * definition without maps.
 */
BuiltMap buildMap(const std::string& path, const BuildParams& params = {});

/** Loads a map from a file of any kind: `.ot`, `.bt`, an MRPT-serialized map (CProbOctoMap,
 * COctoMap, CMultiMetricMap with one of them), or observations to build it from (see buildMap()).
 * \exception std::runtime_error "<path>: <reason>". */
std::shared_ptr<const CProbOctoMap> loadMap(const std::string& path,
                                            const BuildParams& params = {});

/** Saves a map so that all of the file is written or nothing: `.ot` and `.bt` by extension (for
 * maps that asProbOctoMap() knows), else as an MRPT-serialized object, gz-compressed if it ends in
 * `.gz`. \exception std::runtime_error "<path>: <reason>". */
void saveMap(const CMetricMap& map, const std::string& path);

}  // namespace mrpt::maps
