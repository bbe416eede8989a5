// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/poses.h>

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>

/** \file
 * Guesses of poses in g2o files. */

namespace map_fusion {

/** The guesses of a g2o file. The ids are the indices of the maps, from 0. */
struct Priors {
  /** Pose of map b in the frame of map a, by (a, b) with a < b. */
  std::map<std::pair<size_t, size_t>, mrpt::fusion::Prior> pairs;
  std::map<size_t, mrpt::poses::CPose3D> poses;  ///< Poses of maps in one frame

  /** Returns the guess of a pair a < b: that of the pair, or that of both poses. */
  std::optional<mrpt::fusion::Prior> of(size_t a, size_t b) const;
};

/** Parses a g2o file. EDGE_SE3:QUAT is the guess of a pair; its information is the inverse of the
 * covariance of a right perturbation, m and rad. VERTEX_SE3:QUAT is a pose without a covariance.
 * FIX, PARAMS_SE3OFFSET and comments are skipped.
 * \param[in] text Contents of the file.
 * \param[in] maps Number of maps.
 * \exception std::runtime_error "line <n>: <reason>", also if an id is no index of a map, a number
 * is not finite, or an information matrix is not positive definite. */
Priors parsePriors(const std::string& text, size_t maps);

/** Loads a g2o file, see parsePriors(). \exception std::runtime_error "<path>: <reason>". */
Priors loadPriors(const std::string& path, size_t maps);

}  // namespace map_fusion
