// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/export.h>
#include <mrpt/fusion/match_result.h>
#include <mrpt/fusion/search_params.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <Eigen/Geometry>

/** \file
 * Poses as MRPT has them, and what is known of a pose before matching. */

namespace mrpt::fusion {

/** The same pose, m. */
MRPT_FUSION_API Eigen::Isometry3d toEigen(const mrpt::poses::CPose3D& pose);
/** The same pose, m. */
MRPT_FUSION_API mrpt::poses::CPose3D toPose(const Eigen::Isometry3d& T);

/** From the covariance of a left perturbation of T (translation, rotation; A's frame) to MRPT's
 * covariance of (x, y, z, yaw, pitch, roll). Singular at pitch = +-90 deg, as those angles are. */
MRPT_FUSION_API Matrix6d toYawPitchRollCovariance(const Matrix6d& covariance,
                                                  const Eigen::Isometry3d& T);

/** Standard deviation of a position of which nothing is known, m. */
constexpr double kUnknownPoseSigma = 1000;

/** A Gaussian that says nothing but where up is. */
MRPT_FUSION_API mrpt::poses::CPose3DPDFGaussian noGuess();

/** What is known of B's pose in A's frame before matching. */
class MRPT_FUSION_API Prior {
 public:
  /** Nothing but where up is: the search goes everywhere. */
  static Prior none();
  /** A guess of unknown quality: the search goes as far as the options say. */
  static Prior near(const mrpt::poses::CPose3D& guess);
  /** A guess and how good it is: the search goes kSearchSigmas standard deviations far in position,
   * height and yaw; everywhere if that is kUnknownPoseSigma or more; as near() if the covariance is
   * zero. \exception std::exception If the covariance is not finite or has a negative variance. */
  static Prior gaussian(const mrpt::poses::CPose3DPDFGaussian& guess);
  /** As gaussian(), for a program that keeps its guesses as MRPT's Gaussians. */
  Prior(const mrpt::poses::CPose3DPDFGaussian& guess)  // NOLINT(google-explicit-constructor)
      : Prior(gaussian(guess)) {}

  /** The guess; the identity if nothing is known. */
  const mrpt::poses::CPose3D& guess() const { return guess_.mean; }
  /** True if nothing is known. */
  bool isNone() const;
  /** The same as MRPT's Gaussian: noGuess() for none(), a zero covariance for near(). */
  const mrpt::poses::CPose3DPDFGaussian& pdf() const { return guess_; }
  /** The search that this prior asks for. \param[in] configured The search of the options. A
   * configured translation of 0, no search, stays. */
  SearchParams searchWithin(const SearchParams& configured) const;

 private:
  struct Checked {};
  Prior(const mrpt::poses::CPose3DPDFGaussian& guess, Checked) : guess_(guess) {}
  mrpt::poses::CPose3DPDFGaussian guess_;
};

/** Number of standard deviations that Prior::gaussian() has searched. */
constexpr double kSearchSigmas = 3;

}  // namespace mrpt::fusion
