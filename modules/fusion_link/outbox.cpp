// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Chooses the samples that are sent next. */
#include "fusion_link/outbox.h"

#include "fusion_link/statements.h"

namespace mrpt::fusion {
namespace {

/** Size from which no sample is added to a message, bytes: hardly any would fit. */
constexpr size_t kFullMessageBytes = kMostMessageBytes * 15 / 16;

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

void Outbox::setWanted(const std::string& robot, const std::vector<BlockCode>& blocks) {
  if (const auto found = robots_.find(robot); found != robots_.end())
    found->second.wanted.assign(blocks.begin(), blocks.end());
}

/** Fills a message with samples of the map, the most wanted first. What does not fit is left for
 * the next message. \return Keys of the samples. */
std::set<Outbox::Order> Outbox::fill(std::string& message, const Robot& robot) const {
  std::set<Order> taken;
  const auto take = [&](const Order& order) {
    if (taken.count(order) == 0 && addTo(message, samples_.at(order))) taken.insert(order);
  };
  const auto isFull = [&] { return message.size() > kFullMessageBytes; };
  auto rest = robot.lacking.begin();
  for (; rest != robot.lacking.end() && rest->first != SampleKind::Block; ++rest) take(*rest);
  for (const BlockCode code : robot.wanted) {
    const Order order{SampleKind::Block, code};
    if (!isFull() && robot.lacking.count(order) > 0) take(order);
  }
  for (; rest != robot.lacking.end() && !isFull(); ++rest) take(*rest);
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
  while (!robot.wanted.empty() &&
         robot.lacking.count({SampleKind::Block, robot.wanted.front()}) == 0)
    robot.wanted.pop_front();
  return true;
}

void Outbox::sendTo(Link& link) {
  for (auto& [name, robot] : robots_)
    while (sendTo(link, name, robot)) {
    }
}

size_t Outbox::waiting() const {
  size_t count = 0;
  for (const auto& robot : robots_)
    count += robot.second.statements.size() + robot.second.lacking.size();
  return count;
}

}  // namespace mrpt::fusion
