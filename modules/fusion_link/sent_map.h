// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <memory>
#include <string>
#include <vector>

#include "fusion_link/map_replica.h"

/** \file
 * The map that a robot sends. */

namespace mrpt::fusion {

/** Turns the versions of a robot's own map into samples: only what has changed. */
class SentMap {
 public:
  /** Continues after the samples that the robot has sent before it was restarted.
   * \param[in] sent What the robot has of its own map; empty for a new robot.
   * \param[in] run Number of this run of the robot, at random. Two runs then have no version in
   * common, also if the robot has lost its versions in between. */
  explicit SentMap(const MapReplica& sent, unsigned run = 0);

  /** Returns the samples of the next version of the map: the blocks that have changed, the index
   * and, if the map has grown to twice its bytes, the outline. Index and outline come first. Empty
   * if the map is the same as before.
   * \param[in] map The map. It must not change afterwards.
   * \exception std::length_error If the map is too large to send. */
  std::vector<Sample> update(std::shared_ptr<const octomap::OcTree> map);

  /** Returns all samples of the present map with a version above another version. A robot that has
   * lost its versions needs it when others have newer versions than its own.
   * \param[in] version Highest version that another robot has.
   * \exception std::runtime_error If there is no higher version. */
  std::vector<Sample> continueAbove(uint64_t version);

  /** Returns the keys of blocks that the present map no longer has, since the last call. */
  std::vector<SampleKey> takeObsolete() { return std::exchange(obsolete_, {}); }
  /** Returns the present version; 0 if there is no map. */
  uint64_t version() const { return index_.version; }
  /** Returns the present map, null if there is none. */
  const std::shared_ptr<const octomap::OcTree>& map() const { return map_; }

 private:
  uint64_t versionAfter(uint64_t version) const;
  std::vector<Sample> samplesSince(uint64_t version);

  SourceName source_;
  uint64_t run_;
  std::shared_ptr<const octomap::OcTree> map_;
  MapBlocks blocks_;
  MapIndex index_;
  size_t outlined_bytes_ = 0;  // bytes of the blocks of the map of which an outline was sent
  std::vector<SampleKey> obsolete_;
};

}  // namespace mrpt::fusion
