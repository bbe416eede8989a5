// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/maps/CProbOctoMap.h>
#include <octomap/OcTree.h>

#include <chrono>
#include <memory>

/** \file
 * Sends a map to other robots while it is being built. */

namespace mrpt::fusion {

/** Sends a map to the robots of a domain. A thread does it: no function waits for the link or
 * throws. If the map cannot be sent, one line on stderr says why, once.
 *
 * Only one map of a process is sent to a domain: the first that is offered. */
class MapPublisher {
 public:
  /** Does not open the link yet: programs make maps that they never use. */
  explicit MapPublisher(TeamLink link);
  /** Sends what still waits, for at most 6 s. */
  ~MapPublisher();
  MapPublisher(const MapPublisher&) = delete;
  MapPublisher& operator=(const MapPublisher&) = delete;

  /** Sends a map that has changed. The map is copied at most once a second, and so seldom that the
   * copies take at most 2 % of the time. */
  void offer(const octomap::OcTree& map) noexcept;
  /** Sends the last state of the map, if offer() has not copied it. */
  void offerLast(const octomap::OcTree& map) noexcept;

 private:
  class Sender;

  void send(const octomap::OcTree& map) noexcept;

  TeamLink link_;
  std::unique_ptr<Sender> sender_;  // null: nothing was offered, or the map cannot be sent
  bool is_closed_ = false;          // true if the map cannot be sent
  bool is_late_ = false;            // true if the map has changed since it was copied
  std::chrono::steady_clock::time_point next_{};
};

}  // namespace mrpt::fusion
