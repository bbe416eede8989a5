// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <memory>
#include <string>
#include <string_view>

/** \file
 * The outline of a map: what is occupied and what is free, coarse enough for a thin link. */

namespace mrpt::fusion {

/** Largest size of an outline, bytes. */
constexpr size_t kMostOutlineBytes = 10'000;

/** Returns the packed outline of a map: the map on a grid of larger voxels, each occupied or free.
 * The voxels are the smallest with which the outline has at most kMostOutlineBytes, at most 64
 * times those of the map. Empty if there are none.
 * \exception std::exception As transformOcTree(). */
std::string outlineOf(const octomap::OcTree& map);

/** Inverts outlineOf().
 * \exception std::runtime_error If the data is damaged. */
std::unique_ptr<octomap::OcTree> outlineFrom(std::string_view bytes);

}  // namespace mrpt::fusion
