// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/config/CLoadableOptions.h>
#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/matching.h>
#include <mrpt/fusion/merging.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/poses/CPose3DPDFSOG.h>
#include <mrpt/slam/CMetricMapsAlignmentAlgorithm.h>
#include <mrpt/system/CTimeLogger.h>

#include <functional>
#include <string>

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
class CProbabilisticMapMatching : public CMetricMapsAlignmentAlgorithm {
 public:
  CProbabilisticMapMatching();

  /** All parameters of all steps. In .ini files angles end in `_deg`. */
  struct TConfigParams : public mrpt::config::CLoadableOptions {
    mrpt::fusion::MatchParams match;            ///< of edges() and Align3DPDF()
    mrpt::fusion::EvaluationParams evaluation;  ///< of the verdict
    mrpt::fusion::MergeParams merge;            ///< of merge()

    /** Missing keys keep their values. \exception std::exception On a value out of range, or a key
     * in the section that is none of these (a misspelt one would else be ignored). */
    void loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                            const std::string& section) override;
    /** Saves all keys, each with a comment and its unit. */
    void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                          const std::string& section) const override;
  };
  TConfigParams options;  ///< the defaults are those of share/mrpt_fusion/config_files/pmm.ini

  /** What an alignment tells beside the pose. */
  struct TReturnInfo : public TMetricMapAlignmentResult {
    bool by_edges = false;                ///< a map is a CEdgeVoxelMap: edges alone were compared
    unsigned nIterations = 0;             ///< of both levels
    mrpt::fusion::MatchResult match;      ///< pose, covariance, iterations with their MSE, pairs
    mrpt::fusion::Evaluation evaluation;  ///< the verdict and its reasons
    size_t edges_m1 = 0;                  ///< edge voxels of m1
    size_t edges_m2 = 0;                  ///< edge voxels of m2
    size_t voxels_m1 = 0;                 ///< occupied voxels of m1
    size_t voxels_m2 = 0;                 ///< occupied voxels of m2
    /** The distinct poses that were compared, best first, one mode each with its covariance; their
     * log-weights are of how well the maps agree there. Empty without a search. */
    mrpt::poses::CPose3DPDFSOG hypotheses{0};
    double seconds_features = 0;    ///< wall time of what is computed once per map, s
    double seconds_matching = 0;    ///< wall time of search and both levels, s
    double seconds_evaluation = 0;  ///< wall time of the verdict, s
  };

  /** SE(3).
   * \param[in] m1,m2 The maps A and B.
   * \param[in] initialEstimationPDF Its mean is the initial guess (the pose of m2 in m1's
   * frame), and three of its standard deviations bound the search for starts, see searchWithin():
   * noGuess() if nothing is known. With a zero covariance they are those of the options.
   * \param[out] outInfo A TReturnInfo, if wanted.
   * \return A CPose3DPDFGaussian: the pose, and the covariance of (x, y, z, yaw, pitch, roll) from
   * the final Hessian. Check TReturnInfo::evaluation before using it.
   * \exception std::exception If a map is null, of another kind, or has no occupied (edge) voxel.
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
  std::function<void(const mrpt::fusion::IterationRecord&)> onIteration;
};

}  // namespace mrpt::slam

namespace mrpt::fusion {

/** From the covariance of a left perturbation of T (translation, rotation; A's frame) to MRPT's of
 * (x, y, z, yaw, pitch, roll). Singular at pitch = +-90 deg, as those angles are. */
Matrix6d toYawPitchRollCovariance(const Matrix6d& covariance, const Eigen::Isometry3d& T);

/** The search that a prior asks for: up to three standard deviations away. With a zero covariance
 * the one configured; from a kilometre on everywhere(). A configured translation of 0, no search,
 * stays. */
SearchParams searchWithin(const mrpt::poses::CPose3DPDFGaussian& prior,
                          const SearchParams& configured);

/** A prior that says nothing but where up is. */
mrpt::poses::CPose3DPDFGaussian noGuess();

/** MRPT and Eigen poses. */
Eigen::Isometry3d toEigen(const mrpt::poses::CPose3D& pose);
mrpt::poses::CPose3D toPose(const Eigen::Isometry3d& T);

}  // namespace mrpt::fusion
