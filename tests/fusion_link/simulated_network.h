// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "fusion_team/link/link.h"

/** \file
 * A network of robots in one process: the twin of a real link. */

namespace mrpt::fusion::test {

/** A network that loses, repeats and reorders samples, and has partitions. What is lost is sent
 * again. Nothing moves by itself: step() delivers. */
class SimulatedNetwork {
 public:
  /** How bad the network is. */
  struct Quality {
    double loss = 0;        ///< Share of samples that are lost at each step, [0,1)
    double repetition = 0;  ///< Share of samples that arrive twice, [0,1)
    size_t most_sent = 8;   ///< Samples that a robot can send in a step
  };

  explicit SimulatedNetwork(unsigned seed, Quality quality) : random_(seed), quality_(quality) {}

  class Port;
  /** Connects a robot. It gets the latest sample of each key of all robots. The network must
   * outlive the port. */
  std::unique_ptr<Port> connect();

  /** Delivers what has been sent, in any order. */
  void step();
  /** Separates two robots, or connects them again. */
  void separate(const Port& a, const Port& b, bool separated) {
    for (const auto& pair : {std::make_pair(&a, &b), std::make_pair(&b, &a)})
      separated ? (void)separated_.insert(pair) : (void)separated_.erase(pair);
  }
  /** Bytes of all samples that were delivered to a port, by the port that sent them. */
  size_t bytes(const Port& from, const Port& to) const {
    const auto found = bytes_.find({&from, &to});
    return found == bytes_.end() ? 0 : found->second;
  }

 private:
  using Pair = std::pair<const Port*, const Port*>;

  bool chance(double p) { return std::uniform_real_distribution<double>(0, 1)(random_) < p; }

  std::mt19937 random_;
  Quality quality_;
  std::vector<Port*> ports_;
  std::set<Pair> separated_;
  std::map<Pair, std::vector<Sample>> on_the_way_;
  std::map<Pair, size_t> bytes_;
};

/** A robot's link to the network. */
class SimulatedNetwork::Port : public Link {
 public:
  explicit Port(SimulatedNetwork& network) : network_(network) {}
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;
  ~Port() override {
    auto& ports = network_.ports_;
    ports.erase(std::find(ports.begin(), ports.end(), this));
    auto& ways = network_.on_the_way_;
    for (auto way = ways.begin(); way != ways.end();)
      way = way->first.first == this || way->first.second == this ? ways.erase(way) : ++way;
  }

  bool send(const Sample& sample) override {
    if (sent_in_step_ == network_.quality_.most_sent) return false;
    sent_in_step_++;
    latest_[sample.key] = sample;
    for (const Port* port : network_.ports_)
      if (port != this) network_.on_the_way_[{this, port}].push_back(sample);
    return true;
  }
  void forget(const SampleKey& key) override { latest_.erase(key); }
  std::vector<Sample> receive(size_t most) override {
    const size_t n = std::min(most, arrived_.size());
    const auto end = arrived_.begin() + static_cast<ptrdiff_t>(n);
    std::vector<Sample> taken(arrived_.begin(), end);
    arrived_.erase(arrived_.begin(), end);
    return taken;
  }
  void wait(std::chrono::milliseconds) override { network_.step(); }

 private:
  friend class SimulatedNetwork;

  SimulatedNetwork& network_;
  std::map<SampleKey, Sample> latest_;
  std::vector<Sample> arrived_;
  size_t sent_in_step_ = 0;
};

inline std::unique_ptr<SimulatedNetwork::Port> SimulatedNetwork::connect() {
  auto port = std::make_unique<Port>(*this);
  for (const Port* other : ports_)
    for (const auto& sample : other->latest_)
      on_the_way_[{other, port.get()}].push_back(sample.second);
  ports_.push_back(port.get());
  return port;
}

inline void SimulatedNetwork::step() {
  for (Port* port : ports_) port->sent_in_step_ = 0;
  for (Port* to : ports_)
    for (const Port* from : ports_) {
      if (separated_.count({from, to}) > 0) continue;
      auto& way = on_the_way_[{from, to}];
      std::shuffle(way.begin(), way.end(), random_);
      std::vector<Sample> again;
      for (Sample& sample : way) {
        if (chance(quality_.loss)) {
          again.push_back(std::move(sample));
          continue;
        }
        if (chance(quality_.repetition)) again.push_back(sample);
        bytes_[{from, to}] += sample.bytes.size();
        to->arrived_.push_back(std::move(sample));
      }
      way = std::move(again);
    }
}

}  // namespace mrpt::fusion::test
