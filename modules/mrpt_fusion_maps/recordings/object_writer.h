// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/serialization/CSerializable.h>

#include <string>
#include <vector>

/** \file
 * A file of MRPT objects. */

namespace mrpt::fusion {

/** Writes objects one after the other into a file, see saveObject(). */
void saveObjects(const std::vector<const mrpt::serialization::CSerializable*>& objects,
                 const std::string& path);

}  // namespace mrpt::fusion
