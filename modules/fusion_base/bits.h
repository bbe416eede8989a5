// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

/** \file
 * What compilers offer beyond C++17, in one place: bit counts, prefetches, four numbers at a time.
 */

namespace mrpt::fusion {

/** Number of the lowest bit that is set. \param[in] bits Not 0. */
constexpr int lowestBit(uint64_t bits) { return __builtin_ctzll(bits); }

/** Brings an element into the cache by the time that it is needed. */
template <class T>
void prefetch(const std::vector<T>& v, size_t i) {
  __builtin_prefetch(&v[i]);
}

/** Four numbers in one register. */
using Four = float __attribute__((vector_size(16)));

}  // namespace mrpt::fusion
