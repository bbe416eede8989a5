// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

/** \file
 * Compiler extensions beyond C++17: bit counts, prefetches, vectors of 4 numbers, the stack.
 */

namespace mrpt::fusion {

/** Returns the number of the lowest set bit.
 * \param[in] bits The bits; not 0. */
constexpr int lowestBit(uint64_t bits) { return __builtin_ctzll(bits); }

/** Returns the number of set bits. __builtin_popcountll() would call a library function: code for
 * all processors of Debian's amd64 has no instruction for it. */
constexpr int countBits(uint64_t bits) {
  bits -= bits >> 1 & 0x5555555555555555;                                 // of 2 bits each
  bits = (bits & 0x3333333333333333) + (bits >> 2 & 0x3333333333333333);  // of 4 bits each
  bits = (bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0f;                       // of 8 bits each
  return static_cast<int>(bits * 0x0101010101010101 >> 56);
}

/** Loads element i of \a v into the cache, for a later access. */
template <class T>
void prefetch(const std::vector<T>& v, size_t i) {
  __builtin_prefetch(&v[i]);
}

/** Returns the place of the caller on the stack. Differences of two places in one thread are the
 * bytes of the stack between them. */
inline const char* stackPosition() { return static_cast<const char*>(__builtin_frame_address(0)); }

/** 4 numbers in one register. */
using Four = float __attribute__((vector_size(16)));

}  // namespace mrpt::fusion
