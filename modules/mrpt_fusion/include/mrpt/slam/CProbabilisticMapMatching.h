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
 * Finds the pose of map m2 (the scene, "B") in the frame of map m1 (the model, "A"), and says
 * whether that pose can be trusted. After Yue et al., "Hierarchical Probabilistic Fusion Framework
 * for Matching and Merging of 3-D Occupancy Maps".
 *
 * Maps may be CProbOctoMap, COctoMap, or a CMultiMetricMap with one of them; they are not modified.
 * If either is a CEdgeVoxelMap, the edges of both are compared, and free space where it is known:
 * that tells where the maps meet, and is never accepted as a match to merge by.
 * \code
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
  TConfigParams options;  ///< the defaults are those of share/mrpt_fusion/config_files/pmm.ini

  /** What an alignment tells beside the pose. */
  struct TReturnInfo : public TMetricMapAlignmentResult, public mrpt::fusion::Alignment {
    double seconds_features = 0;  ///< Wall time of preparing both maps, s
  };

  /** SE(3).
   * \param[in] m1,m2 The maps A and B.
   * \param[in] initialEstimationPDF Its mean is the initial guess (the pose of m2 in m1's
   * frame), and three of its standard deviations bound the search for starts, see
   * mrpt::fusion::Prior::gaussian(); mrpt::fusion::noGuess() if nothing is known, zero: as the
   * options say. \param[out] outInfo A TReturnInfo, if wanted. \return A CPose3DPDFGaussian: the
   * pose, and the covariance of (x, y, z, yaw, pitch, roll) from the final Hessian. Check
   * TReturnInfo::evaluation before using it. \exception std::exception If a map is null, of another
   * kind, or has no occupied (edge) voxel.
   */
  mrpt::poses::CPose3DPDF::Ptr Align3DPDF(
      const mrpt::maps::CMetricMap* m1, const mrpt::maps::CMetricMap* m2,
      const mrpt::poses::CPose3DPDFGaussian& initialEstimationPDF,
      mrpt::optional_ref<TMetricMapAlignmentResult> outInfo = std::nullopt) override;

  /** SE(2): as Align3DPDF() from a guess in the plane; the result is projected on it (a
   * CPosePDFGaussian of x, y, phi). */
  mrpt::poses::CPosePDF::Ptr AlignPDF(
      const mrpt::maps::CMetricMap* m1, const mrpt::maps::CMetricMap* m2,
      const mrpt::poses::CPosePDFGaussian& initialEstimationPDF,
      mrpt::optional_ref<TMetricMapAlignmentResult> outInfo = std::nullopt) override;

  /** @name Single steps
   * @{ */
  /** The structural edge voxels of a map, in its frame. */
  mrpt::fusion::EdgeVoxels edges(const mrpt::maps::CMetricMap& map) const;
  /** Judges a given pose of m2 in m1. The result's match has the pairs at that pose. */
  TReturnInfo evaluate(const mrpt::maps::CMetricMap& m1, const mrpt::maps::CMetricMap& m2,
                       const mrpt::poses::CPose3D& pose) const;
  /** The map of both, in m1's frame. */
  mrpt::maps::CProbOctoMap merge(const mrpt::maps::CMetricMap& m1, const mrpt::maps::CMetricMap& m2,
                                 const mrpt::poses::CPose3D& pose) const;
  /** @} */

  /** Times the steps, once enabled: features, match, evaluate, merge, edges. */
  mutable mrpt::system::CTimeLogger profiler{false, "CProbabilisticMapMatching"};

  /** Called after each iteration of Align3DPDF(), if set. */
  mrpt::fusion::OnIteration onIteration;
};

}  // namespace mrpt::slam
