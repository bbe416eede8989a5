// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/serialization/CArchive.h>

/** \file
 * The sources of a map in the archives of MRPT. */

namespace mrpt::fusion {

constexpr size_t kMostSources = 100000;   ///< Largest number of sources of a map
constexpr size_t kMostSourceName = 1000;  ///< Largest length of a name, bytes

/** The sources that a map keeps, as they are. */
struct SourcesOfMap {
  /** Copies the sources of a map to a map that will get the same voxels. */
  static void copy(const mrpt::maps::CProbOctoMap& from, mrpt::maps::CProbOctoMap& to);
  /** Writes the sources of a map. */
  static void write(mrpt::serialization::CArchive& out, const mrpt::maps::CProbOctoMap& map);
  /** Reads what write() has written. \exception std::exception If the stream is damaged: memory is
   * taken only for bytes that are there. */
  static void read(mrpt::serialization::CArchive& in, mrpt::maps::CProbOctoMap& map);
};

}  // namespace mrpt::fusion
