// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <utility>

namespace mrpt::fusion {

/** A function of a float, for arguments of which there are few different ones: a map's voxels have
 * a few hundred log-odds between them, and what was computed for most is remembered. 4 kB. Not for
 * several threads. */
template <class F>
class RememberedFunction {
 public:
  /** \param[in] f (float) -> a double. */
  explicit RememberedFunction(F f) : f_(std::move(f)) { known_.fill({0, f_(0.0F)}); }

  /** The function's value. */
  double operator()(float x) {
    uint32_t bits;
    std::memcpy(&bits, &x, sizeof(bits));
    auto& [argument, value] = known_[bits * kGoldenRatio >> 24U];
    if (argument != x) {
      value = f_(x);
      argument = x;
    }
    return value;
  }

 private:
  static constexpr uint32_t kGoldenRatio = 0x9E3779B1;  // spreads what differs in any bits
  struct Known {
    float argument;
    double value;
  };
  F f_;
  std::array<Known, 256> known_;
};

}  // namespace mrpt::fusion
