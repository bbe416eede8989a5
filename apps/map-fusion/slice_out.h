// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "fusion_octree/slice.h"

/** \file
 * Files of slices. */

namespace map_fusion {

/** Returns whether saveSlice() knows the extension: `.pgm`, `.gridmap` or `.gridmap.gz`. */
bool isSliceFile(const std::string& path);

/** Returns the description (`.yaml`) beside a picture of a slice (`.pgm`). Empty for other files.
 */
std::string yamlBeside(const std::string& path);

/** Writes a slice: `.pgm` with its description, otherwise a grid of MRPT.
 * \param[in] thresholds Limits of free and occupied cells of a picture.
 * \exception std::runtime_error "<path>: <reason>". */
void saveSlice(const mrpt::fusion::MapSlice& slice, const mrpt::fusion::CellThresholds& thresholds,
               const std::string& path);

}  // namespace map_fusion
