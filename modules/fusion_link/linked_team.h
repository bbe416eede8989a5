// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/options.h>

#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <string>

#include "fusion_link/dds_link.h"
#include "fusion_link/team_exchange.h"
#include "fusion_link/team_view.h"

/** \file
 * A robot in its team: it exchanges maps, and fuses what it has. */

namespace mrpt::fusion {

/** A robot in its team. It fuses in another thread, so that the link is never left alone. One
 * thread uses it at a time. */
class LinkedTeam {
 public:
  /** \param[in] settings The robot and its link.
   * \param[in] journal Folder of the journal. Empty: without a journal.
   * \param[in] options Parameters of all stages. Nothing: the robot only sends its map. It asks
   * others for outlines at most, and does not fuse.
   * \exception std::runtime_error If the link cannot be opened, or see TeamExchange. */
  LinkedTeam(const DdsSettings& settings, const std::string& journal,
             const std::optional<Options>& options);

  /** Sends the map of this robot, as far as it has changed. The map must not change afterwards. */
  void publish(const std::shared_ptr<const octomap::OcTree>& map);

  /** What a step began and ended. */
  struct Progress {
    bool began = false;  ///< True if a fusion began
    bool ended = false;  ///< True if a fusion ended: knowledge() is new
  };
  /** Receives, sends, and fuses if maps have changed.
   * \exception std::runtime_error If the journal cannot be written, or if this robot has to leave
   * because of its name, see NameDispute. */
  Progress step();
  /** Waits until samples arrive, at most 100 ms. */
  void wait();
  /** Waits for the fusion that runs. \return True if there was one. */
  bool finish();
  /** Sends what still waits, as what this robot has. If nobody is there, it soon gives up. */
  void sayFarewell();

  const TeamKnowledge& knowledge() const { return knowledge_; }  ///< What is known of the team
  const TeamExchange& exchange() const { return exchange_; }     ///< What has arrived
  std::string takeReason() { return exchange_.takeReason(); }    ///< See TeamExchange
  /** Returns true if all that has arrived is in knowledge(). */
  bool isSettled() const { return !thinking_.valid() && !is_new_; }
  /** Returns what is wrong with the name of this robot; empty if nothing is, or if it is not yet
   * clear whether this robot leaves. */
  std::string twinText() const;

 private:
  std::string twin() const;

  std::string name_;
  std::unique_ptr<Link> link_;
  TeamExchange exchange_;
  std::unique_ptr<TeamView> view_;  // of the thread that fuses; null: this robot does not fuse
  std::future<TeamKnowledge> thinking_;
  TeamKnowledge knowledge_;
  bool is_new_ = true;  // true if the maps have changed since the last fusion began
};

}  // namespace mrpt::fusion
