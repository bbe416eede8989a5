// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Settles which of two robots of one name leaves. */
#include "fusion_link/name_dispute.h"

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

std::optional<NameClaim> NameDispute::hear(const NameClaim& claim, int64_t age) {
  if (claim.robot == robot_) return std::nullopt;
  auto other = others_.find(claim.robot);
  const bool is_new = other == others_.end();
  if (is_new && others_.size() >= kMostOthers) return std::nullopt;
  if (is_new) other = others_.emplace(claim.robot, Other{age - claim.age, age}).first;
  const int64_t lead = other->second.lead;
  const bool is_answer = claim.other == robot_;
  const bool is_newer = std::make_pair(lead, robot_) < std::make_pair(claim.lead, claim.robot);
  if (is_answer && is_newer) newer_at_ = other->second.age;
  if (is_answer && !is_newer) is_older_ = true;
  if (is_answer && !is_new) return std::nullopt;
  return NameClaim{robot_, age, claim.robot, lead};
}

}  // namespace mrpt::fusion
