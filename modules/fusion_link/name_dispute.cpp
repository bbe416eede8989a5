// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Settles which of two robots of one name leaves. */
#include "fusion_link/name_dispute.h"

#include <algorithm>
#include <utility>

#include "fusion_base/byte_reader.h"
#include "fusion_base/byte_writer.h"

namespace mrpt::fusion {
namespace {

/** Number of robots of one name that are remembered: bounds the memory. */
constexpr size_t kMostOthers = 64;
/** Longest age and lead that are believed, us: their sums stay far from overflow. */
constexpr int64_t kLongest = int64_t{1} << 60U;

bool isBelievable(int64_t time) { return -kLongest < time && time < kLongest; }

}  // namespace

std::string toBytes(const NameClaim& claim) {
  std::string out;
  appendValue(claim.robot, out);
  appendValue(claim.age, out);
  appendValue(claim.other, out);
  appendValue(claim.lead, out);
  return out;
}

NameClaim nameClaimOf(std::string_view bytes) {
  ByteReader in(bytes);
  NameClaim claim;
  claim.robot = in.take<uint64_t>();
  claim.age = in.take<int64_t>();
  claim.other = in.take<uint64_t>();
  claim.lead = in.take<int64_t>();
  if (in.size() > 0 || !isBelievable(claim.age) || !isBelievable(claim.lead))
    corrupt("a claim of a name is corrupt");
  return claim;
}

/** Returns what is remembered of a robot. If there are too many, the one heard of first is
 * forgotten. */
NameDispute::Other& NameDispute::otherOf(const NameClaim& claim, int64_t age) {
  if (others_.count(claim.robot) == 0 && others_.size() >= kMostOthers)
    others_.erase(
        std::min_element(others_.begin(), others_.end(),
                         [](const auto& a, const auto& b) { return a.second.age < b.second.age; }));
  return others_.try_emplace(claim.robot, Other{age - claim.age, age}).first->second;
}

std::optional<NameClaim> NameDispute::hear(const NameClaim& claim, int64_t age) {
  const bool is_answer = claim.other == robot_;
  if (claim.robot == robot_ || (claim.other != 0 && !is_answer)) return std::nullopt;
  const Other& other = otherOf(claim, age);
  const bool is_newer =
      is_answer ? std::make_pair(other.lead, robot_) < std::make_pair(claim.lead, claim.robot)
                : other.lead < 0;
  if (is_newer) newer_at_ = std::min(newer_at_.value_or(other.age), other.age);
  if (is_answer && !is_newer) is_older_ = true;
  if (is_answer) return std::nullopt;
  return NameClaim{robot_, age, claim.robot, other.lead};
}

}  // namespace mrpt::fusion
