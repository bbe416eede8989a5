// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

/** \file
 * A bound of the work of several threads. */

namespace mrpt::fusion {

/** Bounds the work of all copies of itself together. Whether they throw does not depend on the
 * number of threads. */
class WorkBudget {
 public:
  explicit WorkBudget(uint64_t most)
      : most_(most), left_(std::make_shared<std::atomic<int64_t>>(static_cast<int64_t>(most))) {}

  /** \exception std::length_error If all copies together have taken more than the budget. */
  void take(uint64_t work) {
    constexpr uint64_t kPiece = 4096;  // so that threads do not wait for each other
    taken_ += work;
    if (taken_ < kPiece) return;
    if (left_->fetch_sub(static_cast<int64_t>(taken_)) < static_cast<int64_t>(taken_))
      throw std::length_error(
          "the map has few nodes and large cubes: to turn or refine them takes more than " +
          std::to_string(most_) + " voxels");
    taken_ = 0;
  }

 private:
  uint64_t most_;  // work of all copies
  std::shared_ptr<std::atomic<int64_t>> left_;
  uint64_t taken_ = 0;  // work of this copy since it was last counted
};

}  // namespace mrpt::fusion
