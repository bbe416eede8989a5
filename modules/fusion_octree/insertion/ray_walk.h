// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "fusion_octree/insertion/cell_marks.h"
#include "fusion_octree/insertion/cell_window.h"
#include "fusion_octree/insertion/scan_rays.h"

/** \file
 * Marks the voxels of rays: exactly the voxels of octomap::OcTree::computeRayKeys().
 */

namespace mrpt::fusion {

struct SortedRays;

/** Walks along rays. It keeps memory for the next rays. */
class RayWalker {
 public:
  /** How the rays are walked. The voxels are the same. */
  enum class Lanes {
    Best,  ///< As many rays together as this computer can
    Two    ///< Two rays together, as every computer can
  };

  explicit RayWalker(Lanes lanes = Lanes::Best);
  RayWalker(RayWalker&&) noexcept;
  RayWalker& operator=(RayWalker&&) noexcept;
  ~RayWalker();

  /** Marks the voxels of rays. \param[in] rays The rays. \param[in] origin Their origin.
   * \param[in] window A window that covers the voxels of the origin and of all ends.
   * \param[in,out] marks Marks of this window. \return False if a ray leaves the window. Rays may
   * leave it only at the border of the octree's grid. */
  bool walk(const RayChunk& rays, const RayOrigin& origin, const CellWindow& window,
            CellMarks& marks);

 private:
  bool eight_;
  std::unique_ptr<SortedRays> sorted_;
  std::vector<uint64_t> cells_;
};

}  // namespace mrpt::fusion
