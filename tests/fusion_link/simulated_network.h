// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <deque>
#include <iterator>
#include <map>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "fusion_team/link/link.h"

/** \file
 * A network of robots in one process: the twin of a real link. */

namespace mrpt::fusion::test {

/** A network that loses messages for a while, is slow, and has partitions. A session of two robots
 * ends when they are separated for long, for one of them earlier than for the other. Nothing moves
 * by itself: step() delivers. */
class SimulatedNetwork {
 public:
  /** How bad the network is. */
  struct Quality {
    double loss = 0;       ///< Chance that a message must be sent again, at each step, [0,1)
    size_t most_sent = 8;  ///< Messages that a robot can send to each other robot in a step
  };

  explicit SimulatedNetwork(unsigned seed, Quality quality) : random_(seed), quality_(quality) {}

  class Port;
  /** Connects a robot. The network must outlive the port. */
  std::unique_ptr<Port> connect(const std::string& name);

  /** Delivers what has been sent. */
  void step();
  /** Separates two robots, or connects them again. */
  void separate(const Port& a, const Port& b, bool separated) {
    for (const Pair& pair : {Pair{&a, &b}, Pair{&b, &a}})
      separated ? (void)separated_.emplace(pair, 0) : (void)separated_.erase(pair);
  }
  /** Bytes of all messages that were delivered to a port, by the port that sent them. */
  size_t bytes(const Port& from, const Port& to) const {
    const auto found = bytes_.find({&from, &to});
    return found == bytes_.end() ? 0 : found->second;
  }

 private:
  using Pair = std::pair<const Port*, const Port*>;

  bool chance(double p) { return std::uniform_real_distribution<double>(0, 1)(random_) < p; }
  void endSessions();
  void forget(const Port& port);

  std::mt19937 random_;
  Quality quality_;
  std::vector<Port*> ports_;
  std::map<Pair, int> separated_;      // steps for which the first does not hear the second
  std::map<Pair, uint64_t> sessions_;  // of the first with the second
  uint64_t last_session_ = 0;
  std::map<Pair, std::deque<std::string>> on_the_way_;
  std::map<Pair, size_t> bytes_;
};

/** A robot's link to the network. */
class SimulatedNetwork::Port : public Link {
 public:
  Port(SimulatedNetwork& network, std::string name) : network_(network), name_(std::move(name)) {}
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;
  ~Port() override { network_.forget(*this); }

  std::map<std::string, uint64_t> sessions() override {
    std::map<std::string, uint64_t> sessions;
    for (const Port* other : network_.ports_)
      if (const auto found = network_.sessions_.find({this, other});
          found != network_.sessions_.end())
        sessions[other->name_] = std::max(sessions[other->name_], found->second);
    return sessions;
  }
  bool send(const std::string& robot, const std::string& message) override {
    if (message.size() > kMostMessageBytes) throw std::logic_error("too large a message");
    const Port* latest = nullptr;  // of the robots with this name
    uint64_t session = 0;
    for (const Port* other : network_.ports_) {
      const auto found = network_.sessions_.find({this, other});
      if (other->name_ != robot || found == network_.sessions_.end() || found->second < session)
        continue;
      latest = other;
      session = found->second;
    }
    if (!latest) return false;
    auto& way = network_.on_the_way_[{this, latest}];
    if (way.size() >= network_.quality_.most_sent) return false;
    way.push_back(message);
    return true;
  }
  std::vector<std::string> receive(size_t most) override {
    const size_t n = std::min(most, arrived_.size());
    const auto end = arrived_.begin() + static_cast<ptrdiff_t>(n);
    std::vector<std::string> taken(arrived_.begin(), end);
    arrived_.erase(arrived_.begin(), end);
    return taken;
  }
  void wait(std::chrono::milliseconds) override { network_.step(); }

 private:
  friend class SimulatedNetwork;

  SimulatedNetwork& network_;
  std::string name_;
  std::vector<std::string> arrived_;
};

inline std::unique_ptr<SimulatedNetwork::Port> SimulatedNetwork::connect(const std::string& name) {
  auto port = std::make_unique<Port>(*this, name);
  for (const Port* other : ports_)
    for (const Pair& pair : {Pair{port.get(), other}, Pair{other, port.get()}})
      sessions_[pair] = ++last_session_;
  ports_.push_back(port.get());
  return port;
}

inline void SimulatedNetwork::forget(const Port& port) {
  ports_.erase(std::find(ports_.begin(), ports_.end(), &port));
  const auto erase = [&](auto& map) {
    for (auto entry = map.begin(); entry != map.end();)
      entry = entry->first.first == &port || entry->first.second == &port ? map.erase(entry)
                                                                          : std::next(entry);
  };
  erase(on_the_way_);
  erase(sessions_);
  erase(separated_);
}

/** Ends sessions of robots that are separated, and begins them again. */
inline void SimulatedNetwork::endSessions() {
  for (auto& [pair, steps] : separated_) {
    const int most = pair.first < pair.second ? 3 : 8;
    if (++steps != most) continue;
    sessions_.erase(pair);
    on_the_way_.erase(pair);
    on_the_way_.erase({pair.second, pair.first});
  }
  for (const Port* a : ports_)
    for (const Port* b : ports_)
      if (a != b && separated_.count({a, b}) == 0 && sessions_.count({a, b}) == 0)
        sessions_[{a, b}] = ++last_session_;
}

inline void SimulatedNetwork::step() {
  endSessions();
  for (Port* to : ports_)
    for (const Port* from : ports_) {
      if (separated_.count({to, from}) > 0) continue;
      for (auto& way = on_the_way_[{from, to}]; !way.empty() && !chance(quality_.loss);) {
        bytes_[{from, to}] += way.front().size();
        to->arrived_.push_back(std::move(way.front()));
        way.pop_front();
      }
    }
}

}  // namespace mrpt::fusion::test
