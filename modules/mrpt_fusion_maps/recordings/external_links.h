// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservation.h>

#include <string>

/** \file
 * Names of external files in observations. */

namespace mrpt::fusion {

/** Makes the names of the external files of an observation absolute, so that a recording in another
 * folder finds them. Ranges, points and pictures are not loaded.
 * \param[in,out] obs The observation.
 * \param[in] directory Directory of its external files, with a final '/', see imagesDirectoryOf().
 */
void makeExternalNamesAbsolute(mrpt::obs::CObservation& obs, const std::string& directory);

}  // namespace mrpt::fusion
