// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

/** \file
 * Ratios as text. */

namespace mrpt::fusion {

/** Returns a ratio in percent, with one decimal. */
std::string percent(double ratio);

/** Returns a ratio in percent, with one decimal or as many as make it differ from its limit, at
 * most 4: "90.04 %" is above "90.0 %". */
std::string percentBeside(double limit, double ratio);

}  // namespace mrpt::fusion
