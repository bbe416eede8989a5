// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "fusion_link/map_blocks.h"
#include "fusion_team/link/link.h"

/** \file
 * The samples that wait until the link takes them. */

namespace mrpt::fusion {

/** Samples that wait to be sent. What other robots want goes first: their statements decide the
 * order of the blocks. */
class Outbox {
 public:
  /** Adds a sample. It replaces a waiting sample with the same key. */
  void put(Sample sample);
  /** Takes a sample back if it is waiting. */
  void remove(const SampleKey& key) { waiting_.erase(orderOf(key)); }
  /** Sets the blocks that another robot wants first. */
  void setWanted(const std::string& robot, const std::vector<BlockCode>& blocks);

  /** Gives samples to a link until it is busy: statements, indices, outlines, then the blocks that
   * robots want, one for each robot in turn, then all other blocks.
   * \return Number of samples that were sent. */
  size_t sendTo(Link& link);

  /** Returns the number of waiting samples. */
  size_t size() const { return waiting_.size(); }

 private:
  using Order = std::pair<SampleKind, uint64_t>;
  using Waiting = std::map<Order, Sample>;
  static Order orderOf(const SampleKey& key) { return {key.kind, key.number}; }

  Waiting::iterator next();

  Waiting waiting_;
  std::map<std::string, std::deque<BlockCode>> wanted_;
  std::string last_served_;  // robot whose wish came last
};

}  // namespace mrpt::fusion
