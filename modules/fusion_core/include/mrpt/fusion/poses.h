// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/search_params.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <Eigen/Geometry>

/** \file
 * Conversion of poses from and to MRPT's types, and the prior of a match. */

namespace mrpt::fusion {

/** Converts a pose from MRPT to Eigen, m. */
MRPT_FUSION_API Eigen::Isometry3d toEigen(const mrpt::poses::CPose3D& pose);
/** Converts a pose from Eigen to MRPT, m. */
MRPT_FUSION_API mrpt::poses::CPose3D toPose(const Eigen::Isometry3d& T);

/** Returns the pose of a 4x4 matrix from outside, m. The nearest rotation replaces a rotation that
 * is rounded.
 * \exception std::runtime_error If a number is not finite or the matrix is not a rigid transform to
 * within 1e-3. */
MRPT_FUSION_API Eigen::Isometry3d toRigid(const Eigen::Matrix4d& matrix);

/** Converts the covariance of a left perturbation of T (translation, rotation; A's frame) to MRPT's
 * covariance of (x, y, z, yaw, pitch, roll). The result is singular at pitch = +-90 deg, like these
 * angles. */
MRPT_FUSION_API Matrix6d toYawPitchRollCovariance(const Matrix6d& covariance,
                                                  const Eigen::Isometry3d& T);

/** Inverts toYawPitchRollCovariance(). */
MRPT_FUSION_API Matrix6d fromYawPitchRollCovariance(const Matrix6d& covariance,
                                                    const Eigen::Isometry3d& T);

/** Largest coordinate of a pose from outside, m. Coordinates on the earth are below 1e7 m. */
constexpr double kMostCoordinate = 1e8;

/** Standard deviation of an unknown position, m. */
constexpr double kUnknownPoseSigma = 1000;

/** Returns the Gaussian of an unknown pose of an upright map. */
MRPT_FUSION_API mrpt::poses::CPose3DPDFGaussian noGuess();

/** Knowledge of B's pose in A's frame before matching. */
class MRPT_FUSION_API Prior {
 public:
  /** Returns the prior of an unknown pose: the search goes everywhere. Both maps are upright. */
  static Prior none();
  /** Returns the prior of a guess without a covariance: the options bound the search.
   * \exception std::exception If a number of the guess is not finite or a coordinate is above
   * kMostCoordinate. */
  static Prior near(const mrpt::poses::CPose3D& guess);
  /** Returns the prior of a guess with the standard deviations of its position (m) and of its
   * heading (rad), as gaussian(). \exception std::exception As gaussian(), or if a deviation is
   * not above 0. */
  static Prior within(const mrpt::poses::CPose3D& guess, double position, double heading);
  /** A guess and how good it is: the search goes kSearchSigmas standard deviations far in position,
   * height and yaw; everywhere if that is kUnknownPoseSigma or more; as near() if the covariance is
   * zero. A match farther from the guess is rejected; at least a cell of the search is allowed in
   * position and height, and 1 deg in yaw. \exception std::exception As near(), or if the
   * covariance is not finite or has a negative variance. */
  static Prior gaussian(const mrpt::poses::CPose3DPDFGaussian& guess);
  /** Converts MRPT's Gaussian, as gaussian(). */
  Prior(const mrpt::poses::CPose3DPDFGaussian& guess)  // NOLINT(google-explicit-constructor)
      : Prior(gaussian(guess)) {}

  /** Returns the guess; the identity if the pose is unknown. */
  const mrpt::poses::CPose3D& guess() const { return guess_.mean; }
  /** True if the pose is unknown. */
  bool isNone() const;
  /** True if the prior states how good the guess is: a covariance that is not zero. */
  bool statesCovariance() const;
  /** Returns the prior as MRPT's Gaussian: noGuess() for none(), covariance 0 for near(). */
  const mrpt::poses::CPose3DPDFGaussian& pdf() const { return guess_; }
  /** Returns the search parameters for this prior.
   * \param[in] configured Search parameters of the options. If their translation is 0 (no search),
   * they are returned unchanged. */
  SearchParams searchWithin(const SearchParams& configured) const;

 private:
  struct Checked {};
  Prior(const mrpt::poses::CPose3DPDFGaussian& guess, Checked) : guess_(guess) {}
  mrpt::poses::CPose3DPDFGaussian guess_;
};

/** Half width of the search of Prior::gaussian(), standard deviations. */
constexpr double kSearchSigmas = 3;

}  // namespace mrpt::fusion
