// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Chooses the sample that is sent next. */
#include "fusion_link/outbox.h"

namespace mrpt::fusion {

void Outbox::put(Sample sample) {
  const Order order = orderOf(sample.key);
  waiting_.insert_or_assign(order, std::move(sample));
}

void Outbox::setWanted(const std::string& robot, const std::vector<BlockCode>& blocks) {
  constexpr size_t kMostRobots = 64;
  if (wanted_.size() < kMostRobots || wanted_.count(robot) > 0)
    wanted_[robot] = {blocks.begin(), blocks.end()};
}

Outbox::Waiting::iterator Outbox::next() {
  const auto first = waiting_.begin();
  if (first == waiting_.end() || first->first.first != SampleKind::Block) return first;
  // One wish of each robot in turn, starting after the robot that was served last.
  auto robot = wanted_.upper_bound(last_served_);
  for (size_t i = 0; i < wanted_.size(); i++, ++robot) {
    if (robot == wanted_.end()) robot = wanted_.begin();
    for (auto& wishes = robot->second; !wishes.empty();) {
      const auto sample = waiting_.find({SampleKind::Block, wishes.front()});
      if (sample != waiting_.end()) {
        last_served_ = robot->first;
        return sample;
      }
      wishes.pop_front();  // it was sent
    }
  }
  return first;
}

size_t Outbox::sendTo(Link& link) {
  size_t sent = 0;
  for (auto sample = next(); sample != waiting_.end() && link.send(sample->second);
       sample = next()) {
    waiting_.erase(sample);
    sent++;
  }
  return sent;
}

}  // namespace mrpt::fusion
