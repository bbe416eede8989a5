// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/map_files.h>

#include <string>

/** \file
 * Builds maps from recorded observations. */

namespace mrpt::fusion {

/** Builds a map from a recording. \param[in] path The recording. \param[in] first Its first object.
 * \param[in] params Parameters. \exception std::runtime_error As buildMap(), without the path. */
BuiltMap buildFrom(const std::string& path, const mrpt::serialization::CSerializable& first,
                   const BuildParams& params);

}  // namespace mrpt::fusion
