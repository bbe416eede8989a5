// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/sources.h>

#include <cstddef>
#include <optional>
#include <vector>

/** \file
 * Which maps have the same observations. */

namespace mrpt::fusion {

/** How a map counts, and why. */
struct Share {
  Counting counting = Counting::All;
  std::optional<size_t> with;  ///< Index of a map with the same sources, if not all counts
};

/** Returns how maps count that are fused in an order, so that no observation counts twice.
 *
 * Two maps have the same source if its voxels are the same. A later version of the map of a robot
 * holds the observations of the earlier versions.
 * - A map does not count if another map holds all of its sources. Of maps with the same sources the
 *   first counts.
 * - Of maps that share some sources, the map with the most sources counts, at equal numbers the
 *   first. The other maps add only unknown space.
 * \param[in] maps Sources of each map.
 * Cost: O(sources log(sources)) if few maps share sources. */
std::vector<Share> sharesOf(const std::vector<const Sources*>& maps);

/** Adds the sources that are missing in \a all. A source whose robot is known replaces the same
 * source of an unknown robot. */
void addSources(const Sources& more, Sources& all);

}  // namespace mrpt::fusion
