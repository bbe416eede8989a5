// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * A robot in its team: it exchanges maps, and fuses what it has. */
#include "fusion_link/linked_team.h"

#include <stdexcept>
#include <utility>
#include <vector>

#include "fusion_base/printable.h"

namespace mrpt::fusion {
namespace {

using Clock = std::chrono::steady_clock;

/** Longest time without a look at the link. */
constexpr std::chrono::milliseconds kWaiting{100};
/** As kWaiting, while samples wait to be sent. A busy link waits for itself. */
constexpr std::chrono::milliseconds kWaitingToSend{10};
/** Longest time for which a robot that leaves sends what still waits. */
constexpr std::chrono::seconds kFarewell{3};
/** Time in which the older of the two asks the newer, too, and can say what has happened. */
constexpr std::chrono::milliseconds kBeforeLeaving{1500};

}  // namespace

LinkedTeam::LinkedTeam(const DdsSettings& settings, const std::string& journal,
                       const std::optional<Options>& options)
    : name_(settings.robot), link_(openLink(settings)), exchange_(settings.robot, *link_, journal) {
  if (options)
    view_ = std::make_unique<TeamView>(settings.robot, *options);
  else
    exchange_.askForOutlinesFirst();
}

void LinkedTeam::publish(const std::shared_ptr<const octomap::OcTree>& map) {
  exchange_.askForOutlinesFirst();  // from now on the overlap with a map is known
  exchange_.publish(map);
  is_new_ = true;
}

LinkedTeam::Progress LinkedTeam::step() {
  Progress progress;
  is_new_ = exchange_.step() || is_new_;
  if (exchange_.hasToLeave()) {
    for (const auto end = Clock::now() + kBeforeLeaving; Clock::now() < end; wait())
      exchange_.step();
    throw std::runtime_error(twin() + ": each robot needs a name of its own");
  }
  const bool is_thinking =
      thinking_.valid() && thinking_.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
  if (!is_thinking) progress.ended = finish();
  if (is_thinking || !is_new_ || !view_) return progress;
  is_new_ = false;
  progress.began = true;
  std::vector<MapSnapshot> maps;
  for (const auto& map : exchange_.maps()) maps.emplace_back(map.second);
  thinking_ = std::async(std::launch::async,
                         [this, maps = std::move(maps)] { return view_->update(maps); });
  return progress;
}

bool LinkedTeam::finish() {
  if (!thinking_.valid()) return false;
  knowledge_ = thinking_.get();
  exchange_.want(knowledge_.wanted);
  return true;
}

void LinkedTeam::wait() { link_->wait(exchange_.isWaiting() ? kWaitingToSend : kWaiting); }

void LinkedTeam::sayFarewell() {
  const auto end = Clock::now() + kFarewell;
  while (exchange_.isWaiting() && Clock::now() < end) {
    exchange_.step();
    link_->wait(kWaitingToSend);
  }
}

std::string LinkedTeam::twinText() const {
  return exchange_.hasTwin() && !exchange_.mayLeave() ? twin() : "";
}

std::string LinkedTeam::twin() const {
  return "another robot of this domain has the name " + printable(name_);
}

}  // namespace mrpt::fusion
