// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <utility>

/** \file
 * Cache of the values of a function. */

namespace mrpt::fusion {

/** A function of a float with a cache of its values, for arguments with few distinct values: the
 * voxels of a map have a few hundred distinct log-odds. Memory: 4 kB. Each thread needs its own
 * object. */
template <class F>
class RememberedFunction {
 public:
  /** \param[in] f The function: (float) -> double. */
  explicit RememberedFunction(F f) : f_(std::move(f)) { known_.fill({0, f_(0.0F)}); }

  /** Returns the value of the function. */
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
  static constexpr uint32_t kGoldenRatio = 0x9E3779B1;  // spreads differences in all bits
  struct Known {
    float argument;
    double value;
  };
  F f_;
  std::array<Known, 256> known_;
};

}  // namespace mrpt::fusion
