// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

/** \file
 * Names of maps and robots, made of the names of files. */

namespace mrpt::fusion {

/** Names robots after their files: the name without the extension. If different files have the same
 * name, the names of their folders are added to all names. */
std::vector<std::string> namesOf(const std::vector<std::string>& paths);

/** True if two paths are equal, or lead to the same file. */
bool isSameFile(const std::string& a, const std::string& b);

}  // namespace mrpt::fusion
