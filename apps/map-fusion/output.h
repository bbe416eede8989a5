// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/sources.h>
#include <octomap/OcTree.h>

#include <memory>
#include <string>
#include <vector>

#include "arguments.h"

/** \file
 * Progress on the terminal, and output files. */

namespace map_fusion {

/** Shows the progress of long work in one line on stderr, if stderr is a terminal. */
class Progress {
 public:
  explicit Progress(bool wanted);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void show(const std::string& text);
  void clear();

 private:
  int terminal_;  // copy of stderr, which stays when stderr is silenced; negative: none
  bool shown_ = false;
};

/** Returns whether a path is "-" or names the file, device or pipe that is standard output. */
bool isStandardOutput(const std::string& path);

/** Returns whether two paths name one output. A device such as /dev/null may be named twice. */
bool isSameOutput(const std::string& a, const std::string& b);

/** Checks that a file can be created, so that a long run does not fail at its end.
 * \exception std::runtime_error "<path>: <reason>" if it cannot, or if the file is an input. */
void checkWritable(const std::string& path, const std::vector<std::string>& inputs);

/** True for devices, pipes and standard output ("-"): their names say nothing of what they take. */
bool isDevice(const std::string& path);

/** What the extension of a file says of a map that is written there. */
enum class MapExtension {
  OfMaps,    ///< `.ot`, `.bt`; of MRPT `.gridmap`, `.map`, `.simplemap`, also with `.gz`, and `.gz`
  OfOthers,  ///< Of files that are no maps, or that saveMap() does not write
  Unknown    ///< saveMap() writes an object of MRPT
};
/** Devices, pipes and standard output can take maps. */
MapExtension mapExtensionOf(const std::string& path);

/** Saves a map: `.ot` and `.bt` by extension, `.ot` on standard output ("-"), otherwise as MRPT
 * serializes it. \param[in] sources Sources of the map, which files of octrees do not hold.
 * \exception std::runtime_error "<path>: <reason>". */
void saveMap(const std::shared_ptr<const octomap::OcTree>& map, const std::string& path,
             const mrpt::fusion::Sources& sources = {});

}  // namespace map_fusion
