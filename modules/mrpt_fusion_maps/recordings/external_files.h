// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservation.h>

#include <string>

/** \file
 * Data of recordings that lies in files beside the recording. */

namespace mrpt::fusion {

/** Returns the directory of the external files of a rawlog or a simplemap, with a final '/':
 * "<name>_Images" or "Images" in the folder of the recording. */
std::string imagesDirectoryOf(const std::string& recording);

/** Loads the ranges and points of an observation if they are in external files. Pictures are not
 * loaded: MRPT loads a picture when a map reads it, and most maps read no pictures.
 * \exception std::runtime_error If a file cannot be loaded. The message names the file. */
void loadExternalData(const mrpt::obs::CObservation& obs);

}  // namespace mrpt::fusion
