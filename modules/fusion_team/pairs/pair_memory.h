// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/alignment.h>

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "fusion_team/pairs/pair_evidence.h"

/** \file
 * What is known of pairs of maps from earlier fusions of a team that changes. */

namespace mrpt::fusion {

/** Remembers results that depend on two prepared maps and on what they are keyed by, and on nothing
 * else. So a fusion with a memory gives the same bits as a fusion without. All calls must use the
 * same options. Several threads may use it. */
class PairMemory {
 public:
  /** Makes a result that is not remembered. */
  using Make = std::function<Alignment()>;
  using MakeNumber = std::function<double()>;

  /** Returns the match of two maps with a prior. */
  Alignment match(const PreparedMap& a, const PreparedMap& b, const Prior& prior, const Make& make);
  /** Returns the agreement of two maps with a prior, see coarseAgreement(). */
  double agreement(const PreparedMap& a, const PreparedMap& b, const Prior& prior,
                   const MakeNumber& make);
  /** Returns the registration of B in A from a pose. */
  Alignment registration(const PreparedMap& a, const PreparedMap& b, const Eigen::Isometry3d& T_a_b,
                         const Make& make);
  /** Returns the evidence of two maps. It remembers what the last fusion asked for, see
   * EvidenceOfPair::restart(). */
  std::shared_ptr<EvidenceOfPair> evidence(const PreparedMap& a, const PreparedMap& b,
                                           const Options& options);
  /** Forgets what nothing has asked for since the last call. */
  void forgetUnused();

 private:
  /** A result, and the numbers that it depends on. */
  template <class Result>
  struct Known {
    std::vector<double> key;
    Result result;
    bool is_used;
  };
  template <class Result>
  using Results = std::list<Known<Result>>;
  struct Pair {
    PreparedMap a, b;  // keep the features alive, whose addresses identify the maps
    Results<Alignment> matches, registrations;
    Results<double> agreements;
    std::shared_ptr<EvidenceOfPair> evidence;
    bool is_evidence_used;
  };
  Pair& pairOf(const PreparedMap& a, const PreparedMap& b);
  template <class Result>
  Result remembered(Results<Result> Pair::*kind, const PreparedMap& a, const PreparedMap& b,
                    const std::vector<double>& key, const std::function<Result()>& make);

  std::list<Pair> pairs_;
  std::mutex mutex_;
};

}  // namespace mrpt::fusion
