// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/voxels.h>

#include <cstdint>
#include <vector>

#include "fusion_core/features/surfaces.h"

/** \file
 * Thinning: chooses voxels that represent all voxels. The time of matching is proportional to the
 * number of voxels. */

namespace mrpt::fusion {

/** Chosen voxels of a map. */
struct Thinned {
  std::vector<uint32_t> index;  ///< Indices of the voxels, ascending
  std::vector<float> weight;    ///< Number of voxels that each voxel represents
};
/** Chooses voxels of a map, spread evenly: the voxel with the highest probability in each cube of
 * the octree. The cubes are at least \a spacing (m) wide. Cost: O(voxels). */
Thinned thinOut(const OccupiedVoxels& voxels, double spacing);
/** \overload
 * Chooses the best voxel of each cube by `is_better(i, j) -> bool`. */
template <class IsBetter>
Thinned thinOut(const OccupiedVoxels& voxels, double spacing, IsBetter&& is_better);

/** Chooses few voxels for comparisons of poses, spread evenly. It prefers voxels with a normal.
 * \param[in] all The voxels of a map.
 * \param[in] spacing Width of the cubes that give one voxel each, m.
 * \param[in] enough Largest number of voxels. */
SurfaceVoxels fewOf(const SurfaceVoxels& all, double spacing, size_t enough);

/** Returns the voxels at \a indices. */
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
    uint32_t best = i;  // the voxels of a cube are consecutive in the order of the octree
    for (next = i + 1; next < n && sameCube(i, next); next++)
      if (is_better(next, best)) best = next;
    kept.index.push_back(best);
    kept.weight.push_back(static_cast<float>(next - i));
  }
  return kept;
}

}  // namespace mrpt::fusion
