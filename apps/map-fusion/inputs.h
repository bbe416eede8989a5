// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>

#include <optional>
#include <string>
#include <vector>

#include "mrpt_maps.h"
#include "run_context.h"

/** \file
 * The maps of a run. */

namespace map_fusion {

/** A map that was read from an octree file or a point cloud, and the report on it. */
struct ReadOctree {
  LoadedMap map;
  mrpt::fusion::MapReport report;
};

/** Reads a file ahead of loadMap(), in a thread of its own. Returns nothing if the file is neither
 * an octree nor a point cloud, or if something is wrong with it.
 * \param[in] role See MapReport. */
std::optional<ReadOctree> readAhead(const RunContext& run, const std::string& role,
                                    const std::string& path);

/** Loads the map of a file of any kind, and reports on it. What differs from the file is noted.
 * \param[in] role See MapReport.
 * \param[in] ahead The result of readAhead(), if the file was read ahead.
 * \exception std::runtime_error "<path>: <reason>", also if a command other than `info` gets a map
 * without occupied voxels. */
LoadedMap loadMap(RunContext& run, const std::string& role, const std::string& path,
                  std::optional<ReadOctree> ahead = {});

/** What a file may hold, by its first bytes. */
enum class InputKind {
  OcTree,      ///< `.ot` or `.bt`
  PointCloud,  ///< `.pcd` or `.ply`
  RawNodes,    ///< Nodes of an octree without a header, if `--resolution` is given
  Mrpt         ///< Objects of MRPT: a map, a recording or a mission
};

/** Returns what a file may hold. \exception std::runtime_error "<path>: <reason>" if the file
 * cannot be read or is of a known other kind. */
InputKind inputKindOf(const RunContext& run, const std::string& path);

/** Loads the latest maps of the robots of a recorded mission, or the map of another file, and
 * reports on the maps. The file is read once. \param[in] role Name of a map that is not of a
 * mission. \exception std::runtime_error As loadMap(). */
std::vector<Robot> loadFileOfRobots(RunContext& run, const std::string& role,
                                    const std::string& path);

/** Returns files, each once, in their order. \param[out] repeated Receives those that are left
 * out. */
std::vector<std::string> distinctFiles(const std::vector<std::string>& paths,
                                       std::vector<std::string>* repeated = nullptr);

/** Loads the maps of all robots that the arguments name, and reports on them. A file is a recorded
 * mission, or it holds the map of one robot. \exception std::runtime_error As loadMap(), and if two
 * robots have the same name. */
std::vector<Robot> loadRobots(RunContext& run);

/** Returns the structural edges of a map. \exception std::exception If the map is edges alone. */
mrpt::fusion::EdgeVoxels edgesOf(const RunContext& run, const LoadedMap& map);

}  // namespace map_fusion
