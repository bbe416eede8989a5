// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/poses/CPose3D.h>

#include <iosfwd>
#include <string>

#include "fusion_report/report.h"

/** \file
 * A report for people. */

namespace mrpt::fusion {

constexpr int kValueColumn = 17;  ///< Column where the values of the text begin

/** Returns a pose as MRPT writes it, in m and deg: "[x y z yaw pitch roll]". */
std::string poseText(const mrpt::poses::CPose3D& pose);

/** Prints a report as text: poses in m and deg, ratios in percent, wall times in s. */
void print(const Report& report, std::ostream& out);

}  // namespace mrpt::fusion
