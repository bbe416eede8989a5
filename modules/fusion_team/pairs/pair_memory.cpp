// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Remembers the results of pairs of maps. */
#include "fusion_team/pairs/pair_memory.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace mrpt::fusion {
namespace {

template <class Matrix>
void append(const Matrix& m, std::vector<double>& key) {
  for (Eigen::Index row = 0; row < m.rows(); row++)
    for (Eigen::Index col = 0; col < m.cols(); col++) key.push_back(m(row, col));
}

std::vector<double> keyOf(const Prior& prior) {
  std::vector<double> key;
  append(toEigen(prior.guess()).matrix(), key);
  append(prior.pdf().cov.asEigen(), key);
  return key;
}

bool haveSameBits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

/** Forgets the results that are not used. The others are not used any more. */
template <class Results>
void forgetUnused(Results& results) {
  results.remove_if([](const auto& known) { return !known.is_used; });
  for (auto& known : results) known.is_used = false;
}

}  // namespace

PairMemory::Pair& PairMemory::pairOf(const PreparedMap& a, const PreparedMap& b) {
  const auto known = std::find_if(pairs_.begin(), pairs_.end(), [&](const Pair& p) {
    return &p.a.features() == &a.features() && &p.b.features() == &b.features();
  });
  if (known != pairs_.end()) return *known;
  pairs_.push_back({a, b, {}, {}, {}, nullptr, false});
  return pairs_.back();
}

template <class Result>
Result PairMemory::remembered(Results<Result> Pair::*kind, const PreparedMap& a,
                              const PreparedMap& b, const std::vector<double>& key,
                              const std::function<Result()>& make) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (Known<Result>& known : pairOf(a, b).*kind)
      if (haveSameBits(known.key, key)) {
        known.is_used = true;
        return known.result;
      }
  }
  Result made = make();
  const std::lock_guard<std::mutex> lock(mutex_);
  (pairOf(a, b).*kind).push_back({key, made, true});
  return made;
}

Alignment PairMemory::match(const PreparedMap& a, const PreparedMap& b, const Prior& prior,
                            const Make& make) {
  return remembered(&Pair::matches, a, b, keyOf(prior), make);
}

double PairMemory::agreement(const PreparedMap& a, const PreparedMap& b, const Prior& prior,
                             const MakeNumber& make) {
  return remembered(&Pair::agreements, a, b, keyOf(prior), make);
}

Alignment PairMemory::registration(const PreparedMap& a, const PreparedMap& b,
                                   const Eigen::Isometry3d& T_a_b, const Make& make) {
  std::vector<double> key;
  append(T_a_b.matrix(), key);
  return remembered(&Pair::registrations, a, b, key, make);
}

std::shared_ptr<EvidenceOfPair> PairMemory::evidence(const PreparedMap& a, const PreparedMap& b,
                                                     const Options& options) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Pair& pair = pairOf(a, b);
  if (pair.evidence)
    pair.evidence->restart();
  else
    pair.evidence = std::make_shared<EvidenceOfPair>(a, b, options);
  pair.is_evidence_used = true;
  return pair.evidence;
}

void PairMemory::forgetUnused() {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (Pair& pair : pairs_) {
    mrpt::fusion::forgetUnused(pair.matches);
    mrpt::fusion::forgetUnused(pair.registrations);
    mrpt::fusion::forgetUnused(pair.agreements);
    if (!pair.is_evidence_used) pair.evidence = nullptr;
    pair.is_evidence_used = false;
  }
  pairs_.remove_if([](const Pair& p) {
    return p.matches.empty() && p.registrations.empty() && p.agreements.empty() && !p.evidence;
  });
}

}  // namespace mrpt::fusion
