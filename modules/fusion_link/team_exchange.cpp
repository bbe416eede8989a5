// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * One robot's part of the exchange of maps. */
#include "fusion_link/team_exchange.h"

#include <algorithm>
#include <iterator>
#include <random>
#include <stdexcept>
#include <utility>

#include "fusion_base/byte_reader.h"

namespace mrpt::fusion {
namespace {

/** Messages that are taken from the link at a time: bounds the time of a step. */
constexpr size_t kMostReceived = 64;

/** Highest version of its map that a robot believes others to have: there are enough above it. */
constexpr uint64_t kMostClaim = kMostVersion / 2;

bool isStatement(SampleKind kind) { return kind == SampleKind::Have || kind == SampleKind::Want; }

/** Time after which a robot of the same name is asked again, us: an answer may be lost. */
constexpr int64_t kAskingPeriod = 1'000'000;
/** Robots of the same name that are answered in a step: bounds the memory. Others ask again. A
 * prime, so that the numbers of two robots hardly have one remainder. */
constexpr uint64_t kMostAnswers = 61;

/** Returns a number other than 0. */
uint64_t randomNumber() {
  std::random_device random;
  return (uint64_t{random()} << 32U | random()) | 1U;
}

}  // namespace

TeamExchange::TeamExchange(std::string robot, Link& link, const std::string& journal_folder,
                           ExchangeLimits limits, Clock clock)
    : own_{std::move(robot), {}},
      link_(link),
      limits_(limits),
      clock_(std::move(clock)),
      name_(randomNumber()) {
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
  for (const SampleKey& key : sent_->takeObsolete()) outbox_.remove(key);
  if (journal_) journal_->sync();
}

void TeamExchange::want(const std::vector<WantedBlocks>& wanted) {
  wanted_.clear();
  for (const WantedBlocks& w : wanted) {
    const auto map = maps_.find(w.source);
    if (map == maps_.end() || !w.source.map.empty()) continue;
    WantedBlocks missing{w.source, {}, w.no_others};
    std::copy_if(w.blocks.begin(), w.blocks.end(), std::back_inserter(missing.blocks),
                 [&](BlockCode code) { return map->second.missing().count(code) > 0; });
    wanted_[w.source.robot] = std::move(missing);
  }
  for (auto& [robot, peer] : peers_)
    if (const auto found = wanted_.find(robot); found != wanted_.end())
      stateWanted(robot, peer, found->second);
}

/** States what this robot wants of another robot, if what was stated last does not say it. */
void TeamExchange::stateWanted(const std::string& robot, Peer& peer, const WantedBlocks& wanted) {
  auto stated = peer.wanted.blocks.begin();
  const bool is_said = std::all_of(wanted.blocks.begin(), wanted.blocks.end(), [&](BlockCode code) {
    stated = std::find(stated, peer.wanted.blocks.end(), code);
    return stated != peer.wanted.blocks.end();
  });
  if (is_said && wanted.no_others == peer.wanted.no_others) return;
  peer.wanted = wanted;
  state(robot, SampleKind::Want, 0, toBytes(wanted));
}

/** States what this robot has of the map of another robot, if it is not what was stated last.
 * \param[in] is_begin True to state all: the other robot may not know what arrived before. */
void TeamExchange::stateHoldings(const std::string& robot, Peer& peer, bool is_begin) {
  Holdings holdings;
  if (is_begin) {
    holdings.session = peer.session;
    holdings.asks = peer.heard == 0;
  }
  if (const auto map = maps_.find({robot, {}}); map != maps_.end()) {
    holdings.complete = map->second.completeVersion();
    holdings.highest = map->second.highestVersion();
    if (is_begin)
      for (const Sample& sample : map->second.samples())
        if (sample.version > holdings.complete)
          holdings.marks.insert(markOf(sample.key, sample.version));
  }
  const auto stated = std::make_pair(holdings.complete, holdings.highest);
  if (!is_begin && stated == peer.stated) return;
  peer.stated = stated;
  state(robot, SampleKind::Have, is_begin ? 0 : 1, toBytes(holdings));
}

/** States something. Of one kind and number only what was stated last is sent. */
void TeamExchange::state(const std::string& robot, SampleKind kind, uint64_t number,
                         std::string value) {
  outbox_.state(robot, {{own_, kind, number}, 1, std::move(value)});
}

/** Begins and ends sessions. */
void TeamExchange::meet() {
  const auto sessions = link_.sessions();
  const auto twin = sessions.find(own_.robot);
  meetTwin(twin == sessions.end() ? 0 : twin->second);
  for (auto peer = peers_.begin(); peer != peers_.end();) {
    const auto session = sessions.find(peer->first);
    const bool lasts = session != sessions.end() && session->second == peer->second.session;
    if (!lasts) outbox_.close(peer->first);
    peer = lasts ? std::next(peer) : peers_.erase(peer);
  }
  for (const auto& [robot, session] : sessions) {
    const bool is_allowed = isName(robot) && !robot.empty() && robot != own_.robot;
    if (!is_allowed || peers_.size() >= limits_.maps || peers_.count(robot) > 0) continue;
    Peer& peer = peers_[robot];
    peer.session = session;
    outbox_.open(robot);
    stateHoldings(robot, peer, true);
    const auto wanted = wanted_.find(robot);
    const bool is_new = wanted == wanted_.end();
    stateWanted(robot, peer, is_new ? WantedBlocks{{}, {}, asks_for_outlines_} : wanted->second);
  }
}

/** Asks a robot of the same name at the begin of its session, and then each second as long as this
 * robot may have to leave. Nothing else but answers is said to it. */
void TeamExchange::meetTwin(uint64_t session) {
  if (session != twin_session_) {
    twin_session_ = session;
    outbox_.close(own_.robot);
    if (session == 0) return;
    outbox_.open(own_.robot);
    askTwin();
  } else if (session != 0 && NameDispute::asks(age()) && age() - asked_ >= kAskingPeriod) {
    askTwin();
  }
}

void TeamExchange::askTwin() {
  asked_ = age();
  state(own_.robot, SampleKind::Claim, 0, toBytes(name_.claim(asked_)));
}

void TeamExchange::settleName(const Sample& claim) {
  if (const auto answer = name_.hear(nameClaimOf(claim.bytes), age()))
    state(own_.robot, SampleKind::Claim, 1 + answer->other % kMostAnswers, toBytes(*answer));
}

int64_t TeamExchange::age() const {
  using std::chrono::microseconds;
  return std::chrono::duration_cast<microseconds>(clock_() - begin_).count();
}

bool TeamExchange::step() {
  meet();
  std::vector<Sample> fresh;
  for (const std::string& message : link_.receive(kMostReceived)) receive(message, fresh);
  if (journal_)
    for (const Sample& sample : fresh) journal_->append(sample);
  if (!fresh.empty()) acknowledge();
  // If this robot was restarted without a journal, the others take only what is newer.
  if (highest_heard_ > sent_->version()) send(sent_->continueAbove(highest_heard_));
  outbox_.sendTo(link_);
  return !fresh.empty();
}

/** Takes the samples of a message. \param[out] fresh Samples of maps that are new are added. */
void TeamExchange::receive(const std::string& message, std::vector<Sample>& fresh) {
  const auto refusing = [&](auto&& take) {
    try {
      take();
    } catch (const std::runtime_error& e) {
      refused_++;
      if (reason_.empty()) reason_ = e.what();
    }
  };
  refusing([&] {
    for (Sample& sample : samplesOf(message))
      refusing([&] {
        if (receive(sample)) fresh.push_back(std::move(sample));
      });
  });
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
  if (sample.key.kind == SampleKind::Claim) {
    if (is_own) settleName(sample);
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
    outbox_.setWanted(robot, wantedBlocksOf(statement.bytes));
    return;
  }
  const Holdings held = holdingsOf(statement.bytes);
  if (acknowledged_.size() < limits_.maps || acknowledged_.count(robot) > 0)
    acknowledged_[robot] = held.complete;
  const auto peer = peers_.find(robot);
  if (peer != peers_.end() && held.session != 0) {
    // A session that was heard of before: samples are on their way that the robot does not state.
    if (peer->second.heard != held.session) outbox_.setHeld(robot, held.complete, held.marks);
    peer->second.heard = held.session;
    if (held.asks) {  // it may not have heard what was stated before
      stateHoldings(robot, peer->second, true);
      state(robot, SampleKind::Want, 0, toBytes(peer->second.wanted));
    }
  }
  if (held.highest > kMostClaim) corrupt("a robot claims a version that is too high");
  highest_heard_ = std::max(highest_heard_, held.highest);
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
  for (auto& [robot, peer] : peers_) stateHoldings(robot, peer, false);
}

size_t TeamExchange::bytes() const {
  size_t bytes = 0;
  for (const auto& map : maps_) bytes += map.second.bytes();
  return bytes;
}

}  // namespace mrpt::fusion
