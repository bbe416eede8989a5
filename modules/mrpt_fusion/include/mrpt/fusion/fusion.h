// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/alignment.h>
#include <mrpt/fusion/export.h>
#include <mrpt/maps/CMetricMap.h>
#include <mrpt/maps/CProbOctoMap.h>

#include <memory>
#include <string>

/** \file
 * Fuses two maps in three lines:
 * \code
 * const auto fused = mrpt::fusion::fuse(a, b);
 * if (!fused.accepted()) { std::cerr << fused.why() << "\n"; return 3; }
 * fused.map().saveToOcTreeFile("fused.ot");
 * \endcode */

namespace mrpt::fusion {

/** Prepares a map of MRPT for matching: a CProbOctoMap, COctoMap, CColouredOctoMap,
 * COccupancyGridMap3D, a CMultiMetricMap with such a map, or a CEdgeVoxelMap. The octree is copied,
 * so the result does not refer to \a map. \exception std::exception If the map is of another kind.
 */
MRPT_FUSION_API PreparedMap prepare(const mrpt::maps::CMetricMap& map,
                                    const FeatureParams& params = {});
/** \overload
 * Shares the map, which must not change afterwards. A CProbOctoMap is not copied. */
MRPT_FUSION_API PreparedMap prepare(const std::shared_ptr<const mrpt::maps::CMetricMap>& map,
                                    const FeatureParams& params = {});

/** The result of fuse(). */
class MRPT_FUSION_API Fused {
 public:
  /** Makes a result. \param[in] alignment The match. \param[in] map The fused map. Null: nothing
   * was merged. */
  Fused(Alignment alignment, std::shared_ptr<const mrpt::maps::CProbOctoMap> map);

  /** Returns whether the match is accepted. Only accepted matches are merged. */
  bool accepted() const { return alignment_.evaluation.accepted; }
  /** Returns the reasons of the verdict on one line: of a rejection only those against the pose. */
  std::string why() const;
  /** Returns the fused map, in A's frame. \exception std::logic_error With the reasons, if the
   * match is rejected. */
  const mrpt::maps::CProbOctoMap& map() const;
  /** Returns the pose of B in A's frame, with the covariance of (x, y, z, yaw, pitch, roll). */
  mrpt::poses::CPose3DPDFGaussian pose() const { return alignment_.pose(); }
  /** Returns all results: hypotheses, evidence, pairs. */
  const Alignment& alignment() const { return alignment_; }

 private:
  Alignment alignment_;
  std::shared_ptr<const mrpt::maps::CProbOctoMap> map_;
};

/** Estimates the pose of map B in the frame of map A. Merges both maps if the match is accepted.
 * \param[in] a,b The maps A and B, see prepare(). \param[in] prior Knowledge of the pose of B in
 * A's frame. Default: none. \param[in] options All parameters. \exception std::exception If a map
 * is of another kind, or has no occupied voxel. */
MRPT_FUSION_API Fused fuse(const mrpt::maps::CMetricMap& a, const mrpt::maps::CMetricMap& b,
                           const Prior& prior = Prior::none(), const Options& options = {});
/** \overload
 * Takes prepared maps. */
MRPT_FUSION_API Fused fuse(const PreparedMap& a, const PreparedMap& b,
                           const Prior& prior = Prior::none(), const Options& options = {});

}  // namespace mrpt::fusion
