// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>

#include "fusion_report/report.h"

/** \file
 * A report for people. */

namespace mrpt::fusion {

constexpr int kValueColumn = 17;  ///< Column where the values of the text begin

/** Prints a report as text: poses in m and deg, ratios in percent, wall times in s. */
void print(const Report& report, std::ostream& out);

}  // namespace mrpt::fusion
