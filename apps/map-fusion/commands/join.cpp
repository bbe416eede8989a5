// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion join`. */

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "commands/commands.h"
#include "fusion_base/error_text.h"
#include "fusion_base/printable.h"
#include "fusion_link/linked_team.h"
#include "fusion_link/map_diff.h"
#include "fusion_report/text.h"
#include "live_map.h"
#include "map_pair.h"
#include "mrpt_maps.h"
#include "pages.h"
#include "poses_out.h"
#include "signals.h"

namespace map_fusion {

namespace {

using mrpt::fusion::FusionMember;
using mrpt::fusion::TeamKnowledge;
using mrpt::fusion::TeamState;
using Clock = std::chrono::steady_clock;

/** Time between two looks at the map file. */
constexpr std::chrono::seconds kReadingPeriod{1};
/** Least time between two lines about what is going on. */
constexpr std::chrono::seconds kStatusPeriod{1};
/** Number of different notes about the maps of others: they may be hostile. */
constexpr size_t kMostNotes = 100;

/** Counts periods: isDue() is true once in each. */
class Timer {
 public:
  explicit Timer(Clock::duration period) : period_(period) {}
  bool isDue() {
    if (Clock::now() < next_) return false;
    next_ = Clock::now() + period_;
    return true;
  }

 private:
  Clock::duration period_;
  Clock::time_point next_ = Clock::now();
};

/** A robot in its team. */
class Member {
 public:
  explicit Member(RunContext& run)
      : run_(run),
        team_({run.args.robot, run.args.domain, run.args.peers}, run.args.journal, run.options) {
    if (!run.args.maps.empty()) live_.emplace(run.args.maps.front());
    if (!run.args.recording.empty()) recorder_ = mrptMaps().recordMission(run.args.recording);
  }

  /** Stays in the team until the arguments or a signal say so.
   * \return True if all wanted maps are there, and all robots whose maps are known have joined. */
  bool stay() {
    const auto end = Clock::now() + std::chrono::duration<double>(run_.args.seconds);
    do {
      if (live_ && reading_.isDue()) read();
      const auto progress = team_.step();
      if (progress.ended) take();
      if (progress.began) run_.startStep();
      if (recorder_) record();
      if (status_.isDue()) tell();
      team_.wait();
    } while (!stopWanted() && !isComplete() && (run_.args.seconds <= 0 || Clock::now() < end));
    if (team_.finish()) take();
    const bool is_complete = isComplete();
    if (is_complete) team_.sayFarewell();
    tell();
    const bool has_wanted = run_.args.until_complete == 0 || is_complete;
    if (!has_wanted)
      note("left before the team was complete: " + std::to_string(team_.knowledge().whole_maps) +
           " of " + std::to_string(run_.args.until_complete) + " maps are there as a whole");
    if (!run_.args.output.empty() && !(saved_ && isMerged(*saved_)))
      note(run_.args.output + (has_saved_ ? " is of an earlier state" : " was not written") +
           ": fewer than 2 maps have joined");
    const auto& members = run_.report.members;
    return has_wanted &&
           std::all_of(members.begin(), members.end(), [](const auto& m) { return m.joined; });
  }

 private:
  void read() {
    if (const auto map = live_->readIfChanged(run_)) team_.publish(map);
  }

  /** Records what has changed. A full disk ends the recording, not the robot. */
  void record() {
    try {
      for (const auto& [source, map] : team_.exchange().maps()) {
        uint64_t& version = recorded_[source];
        if (const auto diff = mrpt::fusion::diffSince(map, version)) recorder_->append(*diff);
        if (map.completeVersion() > 0) version = map.completeVersion();
      }
    } catch (const std::runtime_error& e) {
      run_.note(mrpt::fusion::messageOf(e) + " (the recording ends)");
      recorder_.reset();
    }
  }

  void take() {
    const TeamKnowledge& known = team_.knowledge();
    for (const std::string& text : known.notes) note(text);
    if (!known.state || !known.state->map || known.state == saved_) return;
    saved_ = known.state;
    save();
  }

  /** Notes what is wrong, once. */
  void note(const std::string& text) {
    if (notes_.size() < kMostNotes && notes_.insert(text).second) run_.note(text);
  }

  static bool isMerged(const TeamState& state) {
    return std::count_if(state.members.begin(), state.members.end(),
                         [](const FusionMember& m) { return m.joined; }) > 1;
  }

  /** Writes all outputs; the fused map only if maps have joined. */
  void save() {
    const auto& state = *saved_;
    run_.report.members = state.members;
    run_.report.pairs = state.pairs;
    run_.report.maps.clear();
    std::vector<Robot> robots;
    for (const auto& map : team_.knowledge().maps) {
      Robot& robot = robots.emplace_back();
      robot.name = map.robot;
      robot.map.octree = map.map.octree();
      run_.report.maps.push_back(mrpt::fusion::reportOn(map.robot, map.robot, *map.map.octree()));
      run_.report.maps.back().sources = map.map.sources();
    }
    run_.endStep("fuse");
    if (state.members.size() < 2) return;
    const bool is_merged = isMerged(state);
    run_.report.policy = is_merged ? policy_ : std::string();
    if (is_merged && !run_.args.output.empty()) {
      saveFused(run_, state.map, state.sources);
      has_saved_ = true;
    }
    savePoses(run_, is_merged);
    drawTeamPage(run_, robots, is_merged ? state.map : nullptr);
    run_.saveReports();
  }

  bool isComplete() const {
    const size_t wanted = run_.args.until_complete;
    if (wanted == 0 || team_.knowledge().whole_maps < wanted || !team_.isSettled()) return false;
    const auto& own = team_.exchange().maps().at({run_.args.robot, {}});
    const auto& acknowledged = team_.exchange().acknowledged();
    const auto know = std::count_if(acknowledged.begin(), acknowledged.end(), [&](const auto& a) {
      return a.second == own.completeVersion();
    });
    return !live_ || static_cast<size_t>(know) + 1 >= wanted;
  }

  /** Prints one line if it is another line than before. */
  void tell() {
    if (const std::string reason = team_.takeReason(); !reason.empty())
      note("samples are refused: " + reason);
    if (const std::string twin = team_.twinText(); !twin.empty()) note(twin);
    std::string line;
    const auto add = [&](const std::string& text) { line += (line.empty() ? "" : " | ") + text; };
    const TeamKnowledge& known = team_.knowledge();
    for (const auto& [source, map] : team_.exchange().maps()) add(textOf(source, map));
    for (const auto& m : known.meetings) add(textOf(m));
    if (known.state) add(fusedText(known));
    if (run_.args.quiet || line == last_line_) return;
    last_line_ = line;
    std::cout << mrpt::fusion::printable(line) << std::endl;
  }

  std::string textOf(const mrpt::fusion::SourceName& source,
                     const mrpt::fusion::MapReplica& map) const {
    if (!map.index()) return source.robot + " no map";
    const size_t blocks = map.index()->blocks.size();
    return source.robot + " " +
           (map.completeVersion() > 0 ? "complete"
                                      : std::to_string(blocks - map.missing().size()) + "/" +
                                            std::to_string(blocks) + " blocks");
  }
  std::string textOf(const mrpt::fusion::Meeting& m) const {
    const bool is_sure = m.probability >= run_.options.evaluation.min_probability;
    return m.robot + (is_sure ? " meets" : " may meet") + " this robot at " +
           mrpt::fusion::poseText(mrpt::fusion::toPose(m.T_own_other)) + " (" +
           std::to_string(static_cast<int>(100 * m.probability)) + " %, by " +
           std::to_string(m.bytes) + " bytes)";
  }
  static std::string fusedText(const TeamKnowledge& known) {
    std::string names;
    for (const FusionMember& m : known.state->members) {
      if (!m.joined) continue;
      names += (names.empty() ? " " : ", ") + m.robot;
      if (const auto part = known.parts.find(m.robot); part != known.parts.end())
        names += " (" + std::to_string(part->second) + " bytes of it)";
    }
    return "fused" + names;
  }

  RunContext& run_;
  const std::string policy_ = std::exchange(run_.report.policy, {});  // of the merging
  mrpt::fusion::LinkedTeam team_;
  std::optional<LiveMap> live_;
  std::unique_ptr<MissionRecorder> recorder_;              // null: nothing is recorded
  std::map<mrpt::fusion::SourceName, uint64_t> recorded_;  // versions
  std::shared_ptr<const TeamState> saved_;
  Timer reading_{kReadingPeriod}, status_{kStatusPeriod};
  std::string last_line_;
  std::set<std::string> notes_;  // that were printed
  bool has_saved_ = false;       // true if a fused map was written
};

}  // namespace

bool runJoin(RunContext& run) {
  stopAtSignals();
  choosePolicy(run);
  return Member(run).stay();
}

}  // namespace map_fusion
