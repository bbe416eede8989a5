// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/voxels.h>

#include <cstdint>
#include <vector>

#include "fusion_core/features/surfaces.h"

/** \file
 * Fewer voxels that stand for all: matching a third of the voxels takes a third of the time. */

namespace mrpt::fusion {

/** Some of a map's voxels. */
struct Thinned {
  std::vector<uint32_t> index;  ///< ascending
  std::vector<float> weight;    ///< how many voxels each stands for
};
/** Some of a map's voxels, spread evenly: in each cube of the octree that is at least \a spacing
 * (m) wide the most likely occupied one, for all of them. O(voxels). */
Thinned thinOut(const OccupiedVoxels& voxels, double spacing);
/** \overload
 * With `is_better(i, j) -> bool` to choose another than the most likely occupied one. */
template <class IsBetter>
Thinned thinOut(const OccupiedVoxels& voxels, double spacing, IsBetter&& is_better);

/** Few voxels, spread evenly, to compare poses with; voxels that have a normal are preferred.
 * \param[in] all The voxels of a map. \param[in] spacing Width of the cubes that give one voxel
 * each, m. \param[in] enough Most voxels to return. */
SurfaceVoxels fewOf(const SurfaceVoxels& all, double spacing, size_t enough);

/** The voxels at some indices. */
OccupiedVoxels select(const OccupiedVoxels& voxels, const std::vector<uint32_t>& indices);

// ------------------------------------------------------------------------------------------------

template <class IsBetter>
Thinned thinOut(const OccupiedVoxels& voxels, double spacing, IsBetter&& is_better) {
  unsigned shift = 0;
  while (voxels.resolution * (1U << shift) < spacing * (1 - 1e-9) && shift < 15) shift++;
  const auto sameCube = [&](size_t i, size_t j) {
    const octomap::OcTreeKey &a = voxels.key[i], &b = voxels.key[j];
    return a[0] >> shift == b[0] >> shift && a[1] >> shift == b[1] >> shift &&
           a[2] >> shift == b[2] >> shift;
  };
  Thinned kept;
  const auto n = static_cast<uint32_t>(voxels.size());
  for (uint32_t i = 0, next; i < n; i = next) {
    uint32_t best = i;  // in the order of the octree's leaves a cube's voxels follow each other
    for (next = i + 1; next < n && sameCube(i, next); next++)
      if (is_better(next, best)) best = next;
    kept.index.push_back(best);
    kept.weight.push_back(static_cast<float>(next - i));
  }
  return kept;
}

}  // namespace mrpt::fusion
