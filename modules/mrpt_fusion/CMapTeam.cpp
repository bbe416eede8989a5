// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The team of maps for MRPT: it prepares maps and calls mrpt::fusion::MapTeam. */

#include <mrpt/fusion/fusion.h>
#include <mrpt/slam/CMapTeam.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <thread>
#include <utility>

#include "fusion_base/error_text.h"
#include "fusion_link/linked_team.h"

using namespace mrpt::slam;
using namespace mrpt::fusion;
using mrpt::maps::CProbOctoMap;

/** A thread that exchanges and fuses maps. */
class CMapTeam::Linked {
 public:
  Linked(const Options& options, const TTeamLink& link)
      : robot_(link.robot),
        team_({link.robot, link.domain, link.peers}, link.journal, options),
        thread_([this] { run(); }) {}
  ~Linked() {
    is_ending_ = true;
    thread_.join();
  }
  Linked(const Linked&) = delete;
  Linked& operator=(const Linked&) = delete;

  void publish(const std::string& robot, const PreparedMap& map) {
    ASSERTMSG_(robot == robot_, robot + ": a team with a link sets the map of its own robot only");
    const std::lock_guard<std::mutex> lock(mutex_);
    rethrow();
    waiting_ = map.octree();
  }
  std::shared_ptr<const TeamState> state() {
    const std::lock_guard<std::mutex> lock(mutex_);
    rethrow();
    return state_;
  }

 private:
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }
  std::shared_ptr<const octomap::OcTree> takeWaiting() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(waiting_, nullptr);
  }
  void run() {
    try {
      while (!is_ending_) {
        if (const auto map = takeWaiting()) team_.publish(map);
        if (team_.step().ended && team_.knowledge().state) {
          const std::lock_guard<std::mutex> lock(mutex_);
          state_ = team_.knowledge().state;
        }
        team_.wait();
      }
      team_.sayFarewell();
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex_);
      failure_ = std::current_exception();
    }
  }

  const std::string robot_;
  LinkedTeam team_;  // of the thread
  std::atomic<bool> is_ending_{false};
  std::mutex mutex_;  // of all below
  std::shared_ptr<const octomap::OcTree> waiting_;
  std::shared_ptr<const TeamState> state_ = std::make_shared<TeamState>();
  std::exception_ptr failure_;
  std::thread thread_;  // the last member: it uses the others
};

CMapTeam::CMapTeam(const Options& options) : features_(options.features), team_(options) {}
CMapTeam::CMapTeam(const Options& options, const TTeamLink& link)
    : features_(options.features), team_(options), linked_(new Linked(options, link)) {}
CMapTeam::~CMapTeam() = default;

std::shared_ptr<const TeamState> CMapTeam::state() {
  return linked_ ? linked_->state() : team_.state();
}

void CMapTeam::set(const std::string& robot, PreparedMap map,
                   const mrpt::poses::CPose3DPDFGaussian& pose) {
  ASSERTMSG_(map.occupiedVoxels() > 0, robot + ": the map has no occupied voxel");
  if (linked_) return linked_->publish(robot, map);
  team_.set({robot, std::move(map), pose});
}

void CMapTeam::setMap(const std::string& robot, const mrpt::maps::CMetricMap& map,
                      const mrpt::poses::CPose3DPDFGaussian& pose) {
  set(robot, withPath(robot, [&] { return prepare(map, features_); }), pose);
}

bool CMapTeam::setMap(const mrpt::obs::CObservationLocalMap& sent) {
  const std::string& robot = sent.sensorLabel;
  ASSERTMSG_(sent.map, robot + ": the map is missing");
  const std::shared_ptr<const mrpt::maps::CMetricMap> map = sent.map;
  PreparedMap prepared = withPath(robot, [&] { return prepare(map, features_); });
  if (prepared.sources().empty()) prepared = prepared.withSources({{robot, {}, sent.sequence, 0}});
  const std::lock_guard<std::mutex> lock(sequences_mutex_);
  const auto known = sequences_.find(robot);
  if (known != sequences_.end() && sent.sequence < known->second) return false;
  set(robot, std::move(prepared), sent.pose);
  sequences_[robot] = sent.sequence;
  return true;
}

bool CMapTeam::removeMap(const std::string& robot) {
  const std::lock_guard<std::mutex> lock(sequences_mutex_);
  if (!team_.remove(robot)) return false;
  const auto sent = sequences_.find(robot);
  if (sent != sequences_.end() && sent->second < std::numeric_limits<uint64_t>::max())
    sent->second++;
  return true;
}

std::vector<std::string> CMapTeam::robots() const {
  if (!linked_) return team_.robots();
  std::vector<std::string> names;
  for (const FusionMember& member : linked_->state()->members) names.push_back(member.robot);
  return names;
}

std::optional<FusionMember> CMapTeam::member(const std::string& robot) {
  const auto state = this->state();
  const auto found = std::find_if(state->members.begin(), state->members.end(),
                                  [&](const FusionMember& m) { return m.robot == robot; });
  return found == state->members.end() ? std::nullopt : std::optional(*found);
}

std::shared_ptr<const CProbOctoMap> CMapTeam::fusedMap() {
  const auto state = this->state();
  if (!state->map) return nullptr;
  const std::lock_guard<std::mutex> lock(fused_mutex_);
  if (fused_from_ != state) {
    auto map = std::make_shared<CProbOctoMap>(*state->map);
    map->setSources(state->sources);
    fused_ = std::move(map);
    fused_from_ = state;
  }
  return fused_;
}
