// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * One robot's part of the exchange of maps. */
#include "fusion_link/team_exchange.h"

#include <algorithm>
#include <random>
#include <stdexcept>
#include <utility>

#include "fusion_base/byte_reader.h"

namespace mrpt::fusion {
namespace {

/** Samples that are taken from the link at a time: bounds the time of a step. */
constexpr size_t kMostReceived = 256;

/** Highest version of its map that a robot believes others to have: there are enough above it. */
constexpr uint64_t kMostClaim = kMostVersion / 2;

bool isStatement(SampleKind kind) { return kind == SampleKind::Have || kind == SampleKind::Want; }

}  // namespace

TeamExchange::TeamExchange(std::string robot, Link& link, const std::string& journal_folder,
                           ExchangeLimits limits)
    : own_{std::move(robot), {}}, link_(link), limits_(limits) {
  if (!isName(own_.robot) || own_.robot.empty())
    throw std::runtime_error("the name of a robot has 1 to " + std::to_string(kMostNameCharacters) +
                             " printable characters");
  maps_.try_emplace(own_, own_, limits_.bytes_of_map);
  if (!journal_folder.empty())
    journal_ = std::make_unique<Journal>(journal_folder, [&](const Sample& s) { keep(s); });
  const MapReplica& own = maps_.at(own_);
  sent_ = std::make_unique<SentMap>(own, std::random_device()());
  for (Sample& sample : own.samples()) outbox_.put(std::move(sample));
  acknowledge();
}

void TeamExchange::publish(std::shared_ptr<const octomap::OcTree> map) {
  send(sent_->update(std::move(map)));
}

void TeamExchange::send(const std::vector<Sample>& samples) {
  for (const Sample& sample : samples) {
    if (keep(sample) && journal_) journal_->append(sample);
    outbox_.put(sample);
  }
  for (const SampleKey& key : sent_->takeObsolete()) {
    outbox_.remove(key);
    link_.forget(key);
  }
  if (journal_) journal_->sync();
}

void TeamExchange::want(const std::vector<WantedBlocks>& wanted) {
  state(SampleKind::Want, toBytes(wanted));
}

void TeamExchange::state(SampleKind kind, std::string value) {
  auto& [number, last] = stated_[kind];
  if (value == last) return;
  last = std::move(value);
  outbox_.put({{own_, kind, 0}, ++number, last});
}

bool TeamExchange::step() {
  std::vector<Sample> received = link_.receive(kMostReceived);
  const auto is_old = [&](const Sample& sample) {
    try {
      return !receive(sample);
    } catch (const std::runtime_error& e) {
      refused_++;
      if (reason_.empty()) reason_ = e.what();
      return true;
    }
  };
  received.erase(std::remove_if(received.begin(), received.end(), is_old), received.end());
  if (journal_)
    for (const Sample& sample : received) journal_->append(sample);
  if (!received.empty()) acknowledge();
  // If this robot was restarted without a journal, the others take only what is newer.
  if (highest_heard_ > sent_->version()) send(sent_->continueAbove(highest_heard_));
  outbox_.sendTo(link_);
  return !received.empty();
}

bool TeamExchange::receive(const Sample& sample) {
  const SourceName& source = sample.key.source;
  if (source.robot.empty() || !isName(source.robot) || !isName(source.map))
    corrupt("a sample has a name that is not allowed");
  const bool is_own = source.robot == own_.robot;
  if (isStatement(sample.key.kind)) {
    if (!is_own) hear(sample);
    return false;
  }
  if (is_own) corrupt("another robot has the name of this robot");
  return keep(sample);
}

bool TeamExchange::keep(const Sample& sample) {
  const SourceName& source = sample.key.source;
  const auto known = maps_.find(source);
  if (known == maps_.end() && maps_.size() >= limits_.maps) corrupt("there are too many maps");
  if (bytes() + sample.bytes.size() > limits_.bytes) corrupt("all maps have too many bytes");
  if (known != maps_.end()) return known->second.add(sample);
  MapReplica replica(source, limits_.bytes_of_map);
  if (!replica.add(sample)) return false;
  maps_.emplace(source, std::move(replica));
  return true;
}

void TeamExchange::hear(const Sample& statement) {
  const std::string& robot = statement.key.source.robot;
  if (statement.key.kind == SampleKind::Want) {
    for (const WantedBlocks& wanted : wantedBlocksOf(statement.bytes))
      if (wanted.source == own_) outbox_.setWanted(robot, wanted.blocks);
    return;
  }
  for (const HeldVersion& held : heldVersionsOf(statement.bytes)) {
    if (!(held.source == own_)) continue;
    if (acknowledged_.size() < limits_.maps || acknowledged_.count(robot) > 0)
      acknowledged_[robot] = held.complete;
    if (held.highest > kMostClaim) corrupt("a robot claims a version that is too high");
    highest_heard_ = std::max(highest_heard_, held.highest);
  }
}

void TeamExchange::acknowledge() {
  if (journal_) {
    journal_->sync();
    if (journal_->isLarge(bytes())) {
      std::vector<Sample> samples;
      for (const auto& map : maps_)
        for (Sample& sample : map.second.samples()) samples.push_back(std::move(sample));
      journal_->rewrite(samples);
    }
  }
  std::vector<HeldVersion> held;
  for (const auto& [source, map] : maps_)
    if (!(source == own_)) held.push_back({source, map.completeVersion(), map.highestVersion()});
  state(SampleKind::Have, toBytes(held));
}

size_t TeamExchange::bytes() const {
  size_t bytes = 0;
  for (const auto& map : maps_) bytes += map.second.bytes();
  return bytes;
}

}  // namespace mrpt::fusion
