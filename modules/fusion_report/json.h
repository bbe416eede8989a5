// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "fusion_report/report.h"

/** \file
 * A report for programs. */

namespace mrpt::fusion {

/** Returns a report as JSON. doc/report.schema.json describes all keys with their units. Bytes of a
 * path that are not UTF-8 become U+FFFD. */
std::string toJson(const Report& report);

}  // namespace mrpt::fusion
