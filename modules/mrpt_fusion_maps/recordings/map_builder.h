// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/map_files.h>

#include <string>

#include "mrpt_fusion_maps/recordings/recording.h"

/** \file
 * Builds maps from recorded observations. */

namespace mrpt::fusion {

/** Builds a map from a recording. \param[in] path The file. \param[in] first Its first object.
 * \param[in,out] recording All objects of the file. They are freed. Null if \a first is a
 * simplemap. \param[in] params Parameters. \exception std::runtime_error As buildMap(), without the
 * path. */
BuiltMap buildFrom(const std::string& path, const mrpt::serialization::CSerializable& first,
                   Recording* recording, const BuildParams& params);

}  // namespace mrpt::fusion
