// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

/** \file
 * Recognizes files that are no maps. */

namespace mrpt::fusion {

/** Returns what a file that holds no map seems to be and what to do about it, for example "is a
 * point cloud (.pcd): ...". Returns an empty text for a file of an unknown kind, which may be a
 * map. \param[in] beginning First bytes of the file, see beginningOf(). */
std::string foreignKindOf(std::string_view beginning);

/** True if a file begins as MRPT writes objects: rawlog, simplemap, serialized map.
 * \param[in] beginning First bytes of the file, see beginningOf().
 * \param[in] name Name of the class of the object, without namespaces. Empty: any class. */
bool beginsWithObject(std::string_view beginning, std::string_view name = {});

}  // namespace mrpt::fusion
