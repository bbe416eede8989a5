// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Sends a map to other robots while it is being built. */

#include "mrpt_fusion_maps/map_publisher.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <iostream>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "fusion_base/error_text.h"
#include "fusion_base/printable.h"
#include "fusion_link/linked_team.h"

namespace mrpt::fusion {
namespace {

using Clock = std::chrono::steady_clock;

/** Least time between two copies of a map, and the same as a multiple of the time of a copy. */
constexpr std::chrono::seconds kPeriod{1};
constexpr int kPeriodOverCopy = 50;

/** A domain that a map of this process is sent to, as long as the object lives. */
class Domain {
 public:
  explicit Domain(uint32_t number) : number_(number) {
    const std::lock_guard<std::mutex> lock(mutex());
    if (!used().insert(number).second)
      throw std::runtime_error("another map of this program is sent to domain " +
                               std::to_string(number));
  }
  ~Domain() {
    const std::lock_guard<std::mutex> lock(mutex());
    used().erase(number_);
  }
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;

 private:
  static std::mutex& mutex() {
    static std::mutex mutex;
    return mutex;
  }
  static std::set<uint32_t>& used() {
    static std::set<uint32_t> used;
    return used;
  }

  uint32_t number_;
};

void say(const TeamLink& link, const std::exception& e) noexcept {
  try {
    std::cerr << printable("CProbOctoMap: the map of robot '" + link.robot +
                           "' is not sent: " + messageOf(e))
              << std::endl;
  } catch (const std::exception&) {
    // Without memory there is nothing to say.
  }
}

}  // namespace

/** The thread that sends. */
class MapPublisher::Sender {
 public:
  explicit Sender(const TeamLink& link) : link_(link), domain_(link.domain) {
    thread_ = std::thread([this] { run(); });
  }
  ~Sender() {
    is_ending_ = true;
    thread_.join();
  }
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;

  void put(std::shared_ptr<const octomap::OcTree> map) {
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_ = std::move(map);
  }
  bool hasFailed() const { return has_failed_; }

 private:
  std::shared_ptr<const octomap::OcTree> take() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(waiting_, nullptr);
  }
  void run() noexcept {
    try {
      LinkedTeam team({link_.robot, link_.domain, link_.peers}, link_.journal, std::nullopt);
      bool is_last = false;
      while (!is_last) {
        is_last = is_ending_;  // what was put before the end is sent
        if (const auto map = take()) team.publish(map);
        team.step();
        if (!is_last) team.wait();
      }
      team.sayFarewell();
    } catch (const std::exception& e) {
      has_failed_ = true;
      say(link_, e);
    }
  }

  const TeamLink link_;
  const Domain domain_;
  std::atomic<bool> is_ending_{false}, has_failed_{false};
  std::mutex mutex_;  // of the map that waits
  std::shared_ptr<const octomap::OcTree> waiting_;
  std::thread thread_;  // uses the other members
};

MapPublisher::MapPublisher(TeamLink link) : link_(std::move(link)) {}
MapPublisher::~MapPublisher() = default;

void MapPublisher::offer(const octomap::OcTree& map) noexcept {
  if (is_closed_) return;
  is_late_ = true;
  if (Clock::now() >= next_) send(map);
}

void MapPublisher::offerLast(const octomap::OcTree& map) noexcept {
  if (!is_closed_ && is_late_) send(map);
}

void MapPublisher::send(const octomap::OcTree& map) noexcept {
  try {
    if (!sender_) sender_ = std::make_unique<Sender>(link_);
    if (sender_->hasFailed()) {
      is_closed_ = true;
      sender_.reset();
      return;
    }
    const auto begin = Clock::now();
    sender_->put(std::make_shared<const octomap::OcTree>(map));
    const auto end = Clock::now();
    next_ = end + std::max<Clock::duration>(kPeriod, kPeriodOverCopy * (end - begin));
    is_late_ = false;
  } catch (const std::exception& e) {
    is_closed_ = true;
    sender_.reset();
    say(link_, e);
  }
}

}  // namespace mrpt::fusion
