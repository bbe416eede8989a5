// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/alignment.h>

/** \file
 * What a team asks of a pair of maps besides their match. */

namespace mrpt::fusion {

/** Registers B in A from a pose, without a search, and judges the result without rivals.
 * \exception std::exception If a map has only edges. */
Alignment alignFrom(const PreparedMap& a, const PreparedMap& b, const Eigen::Isometry3d& T_a_b,
                    const Options& options);

/** Returns the agreement of two maps at the best pose of a coarse match, see coarseAgreement().
 * \exception std::exception If a map has no occupied voxel, or as align(). */
double coarseAgreement(const PreparedMap& a, const PreparedMap& b, const Prior& prior,
                       const Options& options);

}  // namespace mrpt::fusion
