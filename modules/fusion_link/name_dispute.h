// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

/** \file
 * Which of two robots of one name leaves. */

namespace mrpt::fusion {

/** What a robot says to another robot of its name. Robots count time, but have no common clock. */
struct NameClaim {
  uint64_t robot = 0;  ///< Number of the robot that says this, drawn at random
  int64_t age = 0;     ///< Time since its start, us
  uint64_t other = 0;  ///< Number of the robot to which it answers; 0: it asks all that hear it
  /** Its age when it heard of the other robot, less the age that it heard, us. Too large by the
   * time that the claim was on its way. */
  int64_t lead = 0;
};

/** Returns the value of a sample of SampleKind::Claim. */
std::string toBytes(const NameClaim& claim);
/** Inverts toBytes(). \exception std::runtime_error If the data is damaged. */
NameClaim nameClaimOf(std::string_view bytes);

/** Settles for one robot who keeps its name. Two robots judge by the same two leads, so exactly one
 * of them is the newer. It is the one that started later, if their claims take equally long or the
 * starts are farther apart than a claim takes. A robot with a negative lead started later for sure:
 * it needs no answer, because leads are too large at most.
 *
 * Claims may be lost: a robot asks again and again, as long as asks() says. Each hears the answers
 * to what it asked, so nobody has to know what the others have heard. */
class NameDispute {
 public:
  /** \param[in] robot Number of the robot, drawn at random, not 0. */
  explicit NameDispute(uint64_t robot) : robot_(robot) {}

  /** Robot that may leave: it first hears of an older robot in this time after its start. */
  static constexpr std::chrono::seconds kNewcomer{10};
  /** Age from which a robot never leaves, whatever others say. */
  static constexpr std::chrono::seconds kLongestDispute{60};

  /** Returns what is asked of other robots of the name.
   * \param[in] age Time since the start of this robot, us. */
  NameClaim claim(int64_t age) const { return {robot_, age, 0, 0}; }
  /** Hears a claim. Answers to other robots are ignored.
   * \param[in] age Time since the start of this robot, us.
   * \return The answer, if the other robot needs one. */
  std::optional<NameClaim> hear(const NameClaim& claim, int64_t age);

  /** Returns the age at which this robot first heard of a robot of its name that started earlier,
   * us. Nothing if there is none. */
  std::optional<int64_t> newerAt() const { return newer_at_; }
  /** True if this robot has heard of a robot of its name that started later. */
  bool isOlder() const { return is_older_; }
  /** True if a robot of this age asks again: it may have to leave. */
  static bool asks(int64_t age) { return std::chrono::microseconds(age) < kLongestDispute; }
  /** True if a robot of this age has to leave now. */
  bool hasToLeave(int64_t age) const {
    return newer_at_ && std::chrono::microseconds(*newer_at_) < kNewcomer && asks(age);
  }
  /** True if it is not yet clear whether a robot of this age stays. */
  bool mayLeave(int64_t age) const {
    return !is_older_ && std::chrono::microseconds(age) < kNewcomer;
  }

 private:
  struct Other {
    int64_t lead;  // as NameClaim::lead, of this robot
    int64_t age;   // of this robot when it heard of the other
  };

  Other& otherOf(const NameClaim& claim, int64_t age);

  uint64_t robot_;
  std::map<uint64_t, Other> others_;
  std::optional<int64_t> newer_at_;
  bool is_older_ = false;
};

}  // namespace mrpt::fusion
