// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Chooses the samples that are sent next. */
#include "fusion_link/outbox.h"

#include <utility>

namespace mrpt::fusion {
namespace {

/** Largest size of a message with several samples, bytes: 6 packets of the link over DDS. */
constexpr size_t kGoodMessageBytes = 6 * 1344 - 8;
/** Size from which no sample is added to a message, bytes: hardly any would fit. */
constexpr size_t kFullMessageBytes = kGoodMessageBytes * 15 / 16;

}  // namespace

void Outbox::put(Sample sample) {
  const Order order = orderOf(sample.key);
  samples_.insert_or_assign(order, std::move(sample));
  for (auto& [name, robot] : robots_)
    if (robot.is_known) robot.lacking.insert(order);
}

void Outbox::remove(const SampleKey& key) {
  samples_.erase(orderOf(key));
  for (auto& [name, robot] : robots_) robot.lacking.erase(orderOf(key));
}

void Outbox::state(const std::string& robot, Sample statement) {
  const Order order = orderOf(statement.key);
  if (const auto found = robots_.find(robot); found != robots_.end())
    found->second.statements.insert_or_assign(order, std::move(statement));
}

void Outbox::setHeld(const std::string& robot, uint64_t complete, const std::set<uint64_t>& marks) {
  const auto found = robots_.find(robot);
  if (found == robots_.end()) return;
  found->second.is_known = true;
  auto& lacking = found->second.lacking;
  lacking.clear();
  for (const auto& [order, sample] : samples_)
    if (sample.version > complete && marks.count(markOf(sample.key, sample.version)) == 0)
      lacking.insert(order);
}

void Outbox::setWanted(const std::string& robot, const WantedBlocks& wanted) {
  if (const auto found = robots_.find(robot); found != robots_.end()) found->second.wanted = wanted;
}

/** Calls f(order) for all samples that a robot lacks and wants, some of them twice, until it
 * returns false. */
template <class F>
void Outbox::forEachInOrder(const Robot& robot, F&& f) {
  const auto blocks = robot.lacking.lower_bound({SampleKind::Block, 0});
  for (auto sample = blocks; sample != robot.lacking.begin();)
    if (!f(*--sample)) return;
  for (const BlockCode code : robot.wanted.blocks)
    if (const Order order{SampleKind::Block, code}; robot.lacking.count(order) > 0 && !f(order))
      return;
  if (robot.wanted.no_others) return;
  for (auto block = blocks; block != robot.lacking.end(); ++block)
    if (!f(*block)) return;
}

/** Fills a message with samples of the map, the most wanted first. A block that does not fit is
 * left for the next message. \return Keys of the samples. */
std::set<Outbox::Order> Outbox::fill(std::string& message, const Robot& robot) const {
  std::set<Order> taken;
  forEachInOrder(robot, [&](const Order& order) {
    if (taken.count(order) > 0) return true;
    const size_t most = message.empty() ? kMostMessageBytes : kGoodMessageBytes;
    if (!addTo(message, samples_.at(order), most)) return order.first == SampleKind::Block;
    taken.insert(order);
    return message.size() <= kFullMessageBytes;
  });
  return taken;
}

/** Sends one message. \return False if there is none, or the link is busy. */
bool Outbox::sendTo(Link& link, const std::string& name, Robot& robot) const {
  std::string message;
  auto statement = robot.statements.begin();
  while (statement != robot.statements.end() && addTo(message, statement->second)) ++statement;
  // The first message of a session is small: links begin slowly.
  const std::set<Order> taken = robot.is_new ? std::set<Order>() : fill(message, robot);
  if (message.empty() || !link.send(name, message)) return false;
  robot.is_new = false;
  robot.statements.erase(robot.statements.begin(), statement);
  for (const Order& order : taken) robot.lacking.erase(order);
  return true;
}

void Outbox::sendTo(Link& link) {
  for (auto& [name, robot] : robots_)
    while (sendTo(link, name, robot)) {
    }
}

bool Outbox::isWaiting() const {
  bool is_waiting = false;
  for (const auto& [name, robot] : robots_) {
    is_waiting = is_waiting || !robot.statements.empty();
    forEachInOrder(robot, [&](const Order&) {
      is_waiting = true;
      return false;
    });
  }
  return is_waiting;
}

}  // namespace mrpt::fusion
