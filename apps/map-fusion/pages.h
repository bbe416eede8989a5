// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "map_pair.h"
#include "mrpt_maps.h"
#include "run_context.h"

/** \file
 * What a run shows in its page. */

namespace map_fusion {

/** Draws the picture of the page of two maps, if a page is wanted. */
void drawPage(RunContext& run, const MapPair& pair);

/** Draws the picture of the page of a team, if a page is wanted.
 * \param[in] fused The fused map; null if nothing was merged. */
void drawTeamPage(RunContext& run, const std::vector<Robot>& robots,
                  const std::shared_ptr<const octomap::OcTree>& fused);

/** Draws the picture of the page of maps without a match, in any case. All but the first are
 * hidden: each map has a frame of its own. */
void drawMapsPage(RunContext& run, const std::vector<Robot>& robots);

/** Opens a page in the browser, without waiting for it. \return False if there is no display or no
 * program that opens pages. */
bool openPage(const std::string& path);

}  // namespace map_fusion
