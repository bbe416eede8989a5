// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "fusion_link/statements.h"
#include "fusion_team/link/link.h"

/** \file
 * The samples that wait until the link takes them. */

namespace mrpt::fusion {

/** What a robot sends to the others: statements, and the samples of its map. Each of the others
 * gets what it has not, in the order in which it wants it. */
class Outbox {
 public:
  /** Adds a sample of the map. It replaces the sample with the same key. */
  void put(Sample sample);
  /** Takes a sample of the map out. */
  void remove(const SampleKey& key);

  /** Begins the session of a robot. The robot gets statements only until setHeld(). */
  void open(const std::string& robot) { robots_[robot] = {}; }
  /** Ends the session of a robot. */
  void close(const std::string& robot) { robots_.erase(robot); }
  /** Sends a statement to a robot. It replaces a waiting statement with the same key. */
  void state(const std::string& robot, Sample statement);
  /** Sets what a robot has of the map: nothing of it is sent again.
   * \param[in] complete Version that it has as a whole; 0: none.
   * \param[in] marks Marks of newer samples that it has, see markOf(). */
  void setHeld(const std::string& robot, uint64_t complete, const std::set<uint64_t>& marks);
  /** Sets the blocks that a robot wants first, and whether it wants others. */
  void setWanted(const std::string& robot, const WantedBlocks& wanted);

  /** Gives messages to a link until it is busy. Each robot gets statements, outlines, indices, then
   * the blocks that it wants, then all other blocks. An index comes last before the blocks: who has
   * it has the outline, if there is one. */
  void sendTo(Link& link);

  /** Returns true if something waits for a robot that is there and wants it. */
  bool isWaiting() const;

 private:
  using Order = std::pair<SampleKind, uint64_t>;
  static Order orderOf(const SampleKey& key) { return {key.kind, key.number}; }

  struct Robot {
    bool is_new = true;     // true until the first message
    bool is_known = false;  // true if it has said what it has
    std::map<Order, Sample> statements;
    std::set<Order> lacking;  // samples of the map that it lacks
    WantedBlocks wanted;
  };

  template <class F>
  static void forEachInOrder(const Robot& robot, F&& f);
  std::set<Order> fill(std::string& message, const Robot& robot) const;
  bool sendTo(Link& link, const std::string& name, Robot& robot) const;

  std::map<Order, Sample> samples_;  // of the map
  std::map<std::string, Robot> robots_;
};

}  // namespace mrpt::fusion
