// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/serialization/CSerializable.h>

#include <string>
#include <vector>

/** \file
 * Writes files of MRPT objects. */

namespace mrpt::fusion {

/** Writes objects to a file, one after the other, see saveObject(). */
void saveObjects(const std::vector<const mrpt::serialization::CSerializable*>& objects,
                 const std::string& path);

}  // namespace mrpt::fusion
