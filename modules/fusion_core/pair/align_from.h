// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/alignment.h>

/** \file
 * Registration from a pose that other maps imply. */

namespace mrpt::fusion {

/** Registers B in A from a pose, without a search, and judges the result without rivals.
 * \exception std::exception If a map has only edges. */
Alignment alignFrom(const PreparedMap& a, const PreparedMap& b, const Eigen::Isometry3d& T_a_b,
                    const Options& options);

}  // namespace mrpt::fusion
