// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

/** \file
 * An array that grows without moving its elements. */

namespace mrpt::fusion {

/** A growing array of large elements. Elements keep their places in memory, also when the array
 * itself is moved. */
template <class T>
class ChunkStore {
 public:
  /** Adds an element and returns it. Members without initializer are not set. */
  T& add() {
    if (used_ == kChunk) {
      chunks_.emplace_back(new T[kChunk]);
      used_ = 0;
    }
    return chunks_.back()[used_++];
  }
  /** Removes the element that was added last. */
  void removeLast() { used_--; }
  /** Takes over the elements of another array. */
  void takeAll(ChunkStore&& other) {
    for (auto& chunk : other.chunks_) chunks_.push_back(std::move(chunk));
    used_ = kChunk;  // the last chunk stays as full as it is
    other.chunks_.clear();
    other.used_ = kChunk;
  }

 private:
  static constexpr size_t kChunk = 64;

  std::vector<std::unique_ptr<T[]>> chunks_;
  size_t used_ = kChunk;  // elements of the last chunk
};

}  // namespace mrpt::fusion
