// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/fusion/export.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/math/TPoint3D.h>
#include <mrpt/obs/CObservationLocalMap.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/** \file
 * Loads maps from files of any kind and builds maps from recorded observations. The content of a
 * file decides of which kind it is.
 */

namespace mrpt::fusion {

/** How maps are built from recordings and point clouds. */
struct BuildParams {
  /** Settings with a map definition in the format of MRPT's programs: `<kind>_count` in \a section,
   * and one section for each map. Null: one CProbOctoMap with default options. Not owned. */
  const mrpt::config::CConfigFileBase* config = nullptr;
  std::string section = "MappingApplication";  ///< Section of \a config
  /** Called with the number of inserted observations, if set. */
  std::function<void(size_t inserted)> progress;
  /** Called with a sentence for each difference between a file and its map, if set. */
  std::function<void(const std::string& note)> note;
  double cloud_resolution = 0.1;  ///< Voxel size of maps of point clouds, m
  /** Position of the sensor in the frame of point clouds, m: the space between the sensor and the
   * points is free. Nothing: as the file states it; if it does not, there is no free space. */
  std::optional<mrpt::math::TPoint3D> cloud_sensor_origin = {};
};

/** Observations of one class that a map was built without. */
struct LeftOut {
  std::string kind;    ///< Class of the observations, for example "CObservationImage"
  std::string reason;  ///< Why they were left out
  size_t count = 0;    ///< Number of observations
};

/** The result of buildMap(). */
struct BuiltMap {
  /** The map. It is a CMultiMetricMap if the definition has several maps. */
  mrpt::maps::CMetricMap::Ptr map;
  size_t inserted = 0;            ///< Number of observations that changed the map
  size_t ignored = 0;             ///< Number of all other observations, the sum of left_out
  std::vector<LeftOut> left_out;  ///< Observations that were left out, by class and reason
};

/** Builds a map from a simplemap or a rawlog. The file may be gz-compressed.
 *
 * A simplemap has the poses of its frames. A rawlog must have poses of the robot. In the
 * observations format they are CObservationRobotPose or, if there are none, CObservationOdometry,
 * and they are interpolated to the time of each observation. Without time stamps each observation
 * is at the last pose before it in the log. In the actions format they are robot movements, which
 * are added up. A rawlog without poses, but with the CObservationLocalMap or CObservationMapDiff of
 * one robot, gives the latest map of this robot. Ranges and points in external files are loaded
 * from "<name>_Images", "Images" or the folder of the recording. Pictures are loaded only if a map
 * reads them. \exception std::runtime_error
 * "<path>: <reason>" if the file is of another kind, is truncated or has no poses, if an external
 * file is missing, or if the definition has no map or a map class that MRPT does not know.
 */
MRPT_FUSION_API BuiltMap buildMap(const std::string& path, const BuildParams& params = {});

/** Loads the map of a file of any kind. An octree (`.ot`, `.bt`) and a point cloud
 * (`.pcd`, `.ply`) become a mrpt::maps::CProbOctoMap. An MRPT-serialized map keeps its class. A
 * rawlog with the CObservationLocalMap or CObservationMapDiff of one robot gives the latest map,
 * see loadLocalMaps(). From other recordings a map is built, see buildMap(). \exception
 * std::runtime_error "<path>: <reason>". */
MRPT_FUSION_API mrpt::maps::CMetricMap::Ptr loadAnyMap(const std::string& path,
                                                       const BuildParams& params = {});

/** What a file holds. */
struct FileContents {
  /** Latest maps of the robots of a recorded mission, see loadLocalMaps(). Empty for other files.
   */
  std::vector<mrpt::obs::CObservationLocalMap::Ptr> robots;
  mrpt::maps::CMetricMap::Ptr map;  ///< Map of other files, see loadAnyMap(). Null for a mission
};

/** Loads a mission or a map. Reads the file once, unless it is a recording of more than 256 MB.
 * \exception std::runtime_error "<path>: <reason>". */
MRPT_FUSION_API FileContents loadContents(const std::string& path, const BuildParams& params = {});

/** Loads the 3-D occupancy map of a file, see loadAnyMap() and asProbOctoMap().
 * \exception std::runtime_error "<path>: <reason>". */
MRPT_FUSION_API std::shared_ptr<const mrpt::maps::CProbOctoMap> loadMap(
    const std::string& path, const BuildParams& params = {});

/** Loads the latest map of each robot from a recorded mission: a rawlog with CObservationLocalMap
 * or CObservationMapDiff. The diffs of a robot become one map, with the version as its sequence.
 * The robots are in the order of their first objects. A map that is edges alone is returned only if
 * the robot sent no other map. Returns nothing if the file has no such maps or is not a rawlog.
 * \exception std::runtime_error "<path>: <reason>" if the file cannot be read or is truncated, or
 * if diffs of a robot are missing. */
MRPT_FUSION_API std::vector<mrpt::obs::CObservationLocalMap::Ptr> loadLocalMaps(
    const std::string& path);

/** Writes a recorded mission. The file is gz-compressed if its name ends in `.gz`. Writes the whole
 * file or nothing. \exception std::runtime_error "<path>: <reason>". */
MRPT_FUSION_API void saveLocalMaps(const std::vector<mrpt::obs::CObservationLocalMap::Ptr>& maps,
                                   const std::string& path);

/** A simplemap with a known pose. */
struct PlacedSimpleMap {
  std::string path;                      ///< File of the simplemap
  mrpt::poses::CPose3DPDFGaussian pose;  ///< Pose of its frame in the common frame
};

/** Joins simplemaps: writes the key frames of all maps to one simplemap, in the order of the maps.
 *
 * The pose of a key frame is composed with the pose of its map, and so are the covariances. The
 * composition is a CPose3DPDFGaussian; if mean and covariance of a map are zero, its key frames
 * stay as they are. All key frames of a map share the error of the pose of the map, which a
 * simplemap cannot express. External files stay where they are: their names become absolute.
 * \param[in] maps The simplemaps. \param[in] path The new simplemap, gz-compressed if its name ends
 * in `.simplemap` or `.gz`. The whole file or nothing is written. \return Number of key frames.
 * \exception std::runtime_error "<path>: <reason>". */
MRPT_FUSION_API size_t joinSimpleMaps(const std::vector<PlacedSimpleMap>& maps,
                                      const std::string& path);

/** Saves any object of MRPT. The file is gz-compressed if its name ends in `.gz` or, as simplemaps
 * and scenes of MRPT, in `.simplemap` or `.3Dscene`. Writes the whole file or nothing. \exception
 * std::runtime_error "<path>: <reason>". */
MRPT_FUSION_API void saveObject(const mrpt::serialization::CSerializable& object,
                                const std::string& path);

/** Saves a map. `.ot` and `.bt` files hold the map that asProbOctoMap() returns. All other files
 * hold an MRPT-serialized object, see saveObject(). Writes the whole file or nothing. \exception
 * std::runtime_error "<path>: <reason>". */
MRPT_FUSION_API void saveMap(const mrpt::maps::CMetricMap& map, const std::string& path);

/** Removes the temporary files of all calls of the functions above that have not returned. A signal
 * handler may call it before it ends the program. */
MRPT_FUSION_API void removeTemporaryMapFiles() noexcept;

}  // namespace mrpt::fusion
