// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/alignment.h>
#include <mrpt/fusion/export.h>
#include <mrpt/fusion/poses.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/slam/CMetricMapsAlignmentAlgorithm.h>
#include <mrpt/system/CTimeLogger.h>

#include <memory>

namespace mrpt::slam {

/** Two-level probabilistic map matching (PMM) of 3-D occupancy maps, and the steps around it.
 *
 * Estimates the pose of map m2 (B, the moving map) in the frame of map m1 (A, the reference), and
 * judges whether this pose can be trusted. After Yue et al., "Hierarchical Probabilistic Fusion
 * Framework for Matching and Merging of 3-D Occupancy Maps". In the paper, A is the model map and B
 * the scene map.
 *
 * Maps may be all maps that mrpt::fusion::prepare() takes. They are not modified. If a map is a
 * CEdgeVoxelMap, the edges of both maps are compared, and the free space where it is known. Such a
 * match estimates the pose, but it is never accepted, so that nothing is merged. \code
 * mrpt::slam::CProbabilisticMapMatching pmm;
 * mrpt::slam::CProbabilisticMapMatching::TReturnInfo info;
 * const auto pose = pmm.Align3D(&map_a, &map_b, guess, info);
 * if (info.evaluation.accepted) fused = pmm.merge(map_a, map_b, pose->getMeanVal());
 * \endcode
 */
class MRPT_FUSION_API CProbabilisticMapMatching : public CMetricMapsAlignmentAlgorithm {
 public:
  CProbabilisticMapMatching();

  /** All parameters of all steps. */
  using TConfigParams = mrpt::fusion::Options;
  TConfigParams options;  ///< Defaults: share/mrpt_fusion/config_files/pmm.ini

  /** The results of an alignment other than the pose. */
  struct TReturnInfo : public TMetricMapAlignmentResult, public mrpt::fusion::Alignment {
    double seconds_features = 0;  ///< Wall time of preparing both maps, s
  };

  /** Aligns in SE(3).
   * \param[in] m1,m2 The maps A and B.
   * \param[in] initialEstimationPDF The prior. The mean is the initial guess of the pose of m2 in
   * m1's frame. The search for starts covers 3 standard deviations, see
   * mrpt::fusion::Prior::gaussian(). If nothing is known: mrpt::fusion::noGuess(). With a zero
   * covariance, the options bound the search. \param[out] outInfo A TReturnInfo, if wanted. \return
   * A CPose3DPDFGaussian: the pose, and the covariance of (x, y, z, yaw, pitch, roll) from the
   * final Hessian. Check TReturnInfo::evaluation before you use it.
   * \exception std::exception If a map is null, is of another kind, or has no occupied (edge)
   * voxel.
   */
  mrpt::poses::CPose3DPDF::Ptr Align3DPDF(
      const mrpt::maps::CMetricMap* m1, const mrpt::maps::CMetricMap* m2,
      const mrpt::poses::CPose3DPDFGaussian& initialEstimationPDF,
      mrpt::optional_ref<TMetricMapAlignmentResult> outInfo = std::nullopt) override;

  /** Aligns in SE(2): calls Align3DPDF() with a guess in the plane, and projects the result on the
   * plane. \return A CPosePDFGaussian of (x, y, phi). */
  mrpt::poses::CPosePDF::Ptr AlignPDF(
      const mrpt::maps::CMetricMap* m1, const mrpt::maps::CMetricMap* m2,
      const mrpt::poses::CPosePDFGaussian& initialEstimationPDF,
      mrpt::optional_ref<TMetricMapAlignmentResult> outInfo = std::nullopt) override;

  /** @name Single steps
   * @{ */
  /** Extracts the structural edge voxels of a map, in its frame. */
  mrpt::fusion::EdgeVoxels edges(const mrpt::maps::CMetricMap& map) const;
  /** Judges a given pose of m2 in m1. The match of the result has the pairs at this pose. */
  TReturnInfo evaluate(const mrpt::maps::CMetricMap& m1, const mrpt::maps::CMetricMap& m2,
                       const mrpt::poses::CPose3D& pose) const;
  /** Merges both maps, in m1's frame. */
  mrpt::maps::CProbOctoMap merge(const mrpt::maps::CMetricMap& m1, const mrpt::maps::CMetricMap& m2,
                                 const mrpt::poses::CPose3D& pose) const;
  /** @} */

  /** Measures the steps features, match, evaluate, merge and edges, if it is enabled. */
  mutable mrpt::system::CTimeLogger profiler{false, "CProbabilisticMapMatching"};

  /** Called after each iteration of Align3DPDF(), if set. */
  mrpt::fusion::OnIteration onIteration;
};

}  // namespace mrpt::slam
