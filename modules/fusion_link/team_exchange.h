// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "fusion_link/journal.h"
#include "fusion_link/map_replica.h"
#include "fusion_link/name_dispute.h"
#include "fusion_link/outbox.h"
#include "fusion_link/sent_map.h"
#include "fusion_link/statements.h"
#include "fusion_team/link/link.h"

/** \file
 * Exchanges the maps of a team over a link. */

namespace mrpt::fusion {

/** Bounds of what other robots can make a robot keep. */
struct ExchangeLimits {
  size_t maps = 64;                              ///< Number of maps
  size_t bytes_of_map = MapReplica::kMostBytes;  ///< Bytes of the samples of one map
  size_t bytes = 4 * MapReplica::kMostBytes;     ///< Bytes of the samples of all maps
};

/** One robot's part of the exchange: it sends what changes in the map of the robot, and collects
 * the maps of the others. What it collects is in the journal before it is acknowledged.
 *
 * When a session of two robots begins, each says what it has of the map of the other. So nothing is
 * sent twice, also after a partition or a restart.
 *
 * One thread uses an exchange at a time. */
class TeamExchange {
 public:
  /** Tells the time. */
  using Clock = std::function<std::chrono::steady_clock::time_point()>;

  /** Continues where the journal ends.
   * \param[in] robot Name of the robot, or of a station that has no map.
   * \param[in] link The link; not owned, it must outlive the exchange.
   * \param[in] journal_folder Folder of the journal. Empty: without a journal.
   * \param[in] limits See ExchangeLimits.
   * \param[in] clock The clock of the robot. The robot starts now.
   * \exception std::runtime_error If the name is empty or too long, or see Journal. */
  TeamExchange(std::string robot, Link& link, const std::string& journal_folder = {},
               ExchangeLimits limits = {}, Clock clock = std::chrono::steady_clock::now);

  /** Sends the map of the robot, as far as it has changed.
   * \param[in] map The map. It must not change afterwards. \exception std::exception See
   * SentMap::update(). */
  void publish(std::shared_ptr<const octomap::OcTree> map);
  /** Asks robots that come, and whose maps are not known, for their outlines only, until want()
   * asks for more. */
  void askForOutlinesFirst() { asks_for_outlines_ = true; }
  /** Asks for the blocks that the robot wants first. */
  void want(const std::vector<WantedBlocks>& wanted);
  /** Receives what has arrived, and sends what the link takes.
   * \return True if a sample of a map was new.
   * \exception std::runtime_error If the journal cannot be written. */
  bool step();

  /** Returns all maps, by their names. That of this robot is one of them; it may be empty. */
  const std::map<SourceName, MapReplica>& maps() const { return maps_; }
  /** Returns true if something waits for a robot that is there and wants it. */
  bool isWaiting() const { return outbox_.isWaiting(); }
  /** True if another robot that is there has the name of this robot. */
  bool hasTwin() const { return twin_session_ != 0; }
  /** True if this robot has to leave now, because of a robot of its name that started earlier. */
  bool hasToLeave() const { return name_.hasToLeave(age()); }
  /** True if it is not yet clear whether this robot stays if another has its name. */
  bool mayLeave() const { return name_.mayLeave(age()); }
  /** Returns the versions that other robots have of this robot's map, by their names. */
  const std::map<std::string, uint64_t>& acknowledged() const { return acknowledged_; }
  /** Returns the number of samples that were refused. */
  size_t refused() const { return refused_; }
  /** Returns the reason of the first refusal since the last call; empty if there is none. */
  std::string takeReason() { return std::exchange(reason_, {}); }

 private:
  /** What was stated last to a robot that is there. */
  struct Peer {
    uint64_t session = 0;
    uint64_t heard = 0;  // number that it gave to the session when it said what it has
    std::pair<uint64_t, uint64_t> stated;  // versions of its map, complete and highest
    WantedBlocks wanted;                   // stated last; nothing was stated: all blocks
  };

  void meet();
  void meetTwin(uint64_t session);
  void askTwin();
  void settleName(const Sample& claim);
  int64_t age() const;
  void receive(const std::string& message, std::vector<Sample>& fresh);
  bool receive(const Sample& sample);
  bool keep(const Sample& sample);
  void hear(const Sample& statement);
  void send(const std::vector<Sample>& samples);
  void state(const std::string& robot, SampleKind kind, uint64_t number, std::string value);
  void stateHoldings(const std::string& robot, Peer& peer, bool is_begin);
  void stateWanted(const std::string& robot, Peer& peer, const WantedBlocks& wanted);
  void acknowledge();
  size_t bytes() const;

  SourceName own_;
  Link& link_;
  ExchangeLimits limits_;
  std::map<SourceName, MapReplica> maps_;
  std::unique_ptr<Journal> journal_;
  std::unique_ptr<SentMap> sent_;  // never null after the construction
  Outbox outbox_;
  std::map<std::string, Peer> peers_;           // robots that are there
  std::map<std::string, WantedBlocks> wanted_;  // by the robot whose map it is
  bool asks_for_outlines_ = false;
  std::map<std::string, uint64_t> acknowledged_;
  uint64_t highest_heard_ = 0;  // highest version of this robot's map that others have
  const Clock clock_;
  const std::chrono::steady_clock::time_point begin_ = clock_();
  NameDispute name_;
  uint64_t twin_session_ = 0;  // with a robot of the same name; 0: none
  int64_t asked_ = 0;          // age at which it was asked last, us
  size_t refused_ = 0;
  std::string reason_;
};

}  // namespace mrpt::fusion
