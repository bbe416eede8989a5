// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/match_result.h>

#include <string>

/** \file
 * The standard deviations of a pose as text. */

namespace mrpt::fusion {

/** Returns the standard deviations of a pose as text, with their directions in map A's frame: in
 * which directions map B slides or turns freely, or by how much its pose is uncertain. */
std::string textOf(const PoseDeviation& deviation);

}  // namespace mrpt::fusion
