// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/alignment.h>
#include <mrpt/fusion/export.h>
#include <mrpt/maps/CMetricMap.h>
#include <mrpt/maps/CProbOctoMap.h>

#include <memory>
#include <string>

/** \file
 * Two maps to one in three lines:
 * \code
 * const auto fused = mrpt::fusion::fuse(a, b);
 * if (!fused.accepted()) { std::cerr << fused.why() << "\n"; return 3; }
 * fused.map().saveToOcTreeFile("fused.ot");
 * \endcode */

namespace mrpt::fusion {

/** Prepares a map of MRPT's for matching: a CProbOctoMap, COctoMap, CColouredOctoMap,
 * COccupancyGridMap3D, a CMultiMetricMap with such a map, or a CEdgeVoxelMap. The result does not
 * refer to \a map: its octree is copied. \exception std::exception If the map is of another kind.
 */
MRPT_FUSION_API PreparedMap prepare(const mrpt::maps::CMetricMap& map,
                                    const FeatureParams& params = {});
/** \overload
 * Shares the map, which must not change afterwards, and copies nothing of a CProbOctoMap. */
MRPT_FUSION_API PreparedMap prepare(const std::shared_ptr<const mrpt::maps::CMetricMap>& map,
                                    const FeatureParams& params = {});

/** What fuse() came to. */
class MRPT_FUSION_API Fused {
 public:
  /** \param[in] alignment The match. \param[in] map The fused map; null: nothing was merged. */
  Fused(Alignment alignment, std::shared_ptr<const mrpt::maps::CProbOctoMap> map);

  /** True if the match can be trusted; only then the maps are merged. */
  bool accepted() const { return alignment_.evaluation.accepted; }
  /** The reasons of the verdict, on one line. */
  std::string why() const;
  /** The fused map, in A's frame. \exception std::logic_error If the match is rejected; it says
   * why. */
  const mrpt::maps::CProbOctoMap& map() const;
  /** Pose of B in A's frame, with its covariance of (x, y, z, yaw, pitch, roll). */
  mrpt::poses::CPose3DPDFGaussian pose() const { return alignment_.pose(); }
  /** All that was found out on the way: hypotheses, evidence, pairs. */
  const Alignment& alignment() const { return alignment_; }

 private:
  Alignment alignment_;
  std::shared_ptr<const mrpt::maps::CProbOctoMap> map_;
};

/** Finds the pose of map B in the frame of map A and, if it can be trusted, merges both maps.
 * \param[in] a,b The maps A and B, see prepare(). \param[in] prior What is known of B's pose in A's
 * frame; nothing by default. \param[in] options All parameters. \exception std::exception If a map
 * is of another kind, or has no occupied voxel. */
MRPT_FUSION_API Fused fuse(const mrpt::maps::CMetricMap& a, const mrpt::maps::CMetricMap& b,
                           const Prior& prior = Prior::none(), const Options& options = {});
/** \overload
 * Of maps that are prepared already. */
MRPT_FUSION_API Fused fuse(const PreparedMap& a, const PreparedMap& b,
                           const Prior& prior = Prior::none(), const Options& options = {});

}  // namespace mrpt::fusion
