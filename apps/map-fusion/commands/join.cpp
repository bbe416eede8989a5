// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion join`. */

#include <algorithm>
#include <chrono>
#include <future>
#include <iostream>
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
#include "fusion_link/dds_link.h"
#include "fusion_link/team_exchange.h"
#include "fusion_link/team_view.h"
#include "fusion_report/text.h"
#include "live_map.h"
#include "map_pair.h"
#include "module.h"
#include "pages.h"
#include "poses_out.h"
#include "signals.h"

namespace map_fusion {

namespace {

using mrpt::fusion::FusionMember;
using mrpt::fusion::TeamKnowledge;
using Clock = std::chrono::steady_clock;

/** Time between two looks at the map file. */
constexpr std::chrono::seconds kReadingPeriod{1};
/** Least time between two lines about what is going on. */
constexpr std::chrono::seconds kStatusPeriod{1};
/** Longest time without a look at the link. */
constexpr std::chrono::milliseconds kWaiting{100};
/** As kWaiting, while samples wait to be sent. A busy link waits for itself. */
constexpr std::chrono::milliseconds kWaitingToSend{10};

/** A robot that finds another robot of its name in this time is the newer of the two, and leaves.
 */
constexpr std::chrono::seconds kNewcomer{10};

/** Number of different notes about the maps of others: they may be hostile. */
constexpr size_t kMostNotes = 100;
/** Longest time for which a robot that leaves sends what still waits. */
constexpr std::chrono::seconds kFarewell{3};

std::unique_ptr<mrpt::fusion::Link> openLink([[maybe_unused]] const Arguments& args) {
#ifdef DDS_MODULE
  const auto open = reinterpret_cast<mrpt::fusion::OpenDdsLink>(
      functionOfModule(DDS_MODULE, mrpt::fusion::kOpenDdsLink, "the link"));
  return std::unique_ptr<mrpt::fusion::Link>(open({args.robot, args.domain, args.peers}));
#else
  throw std::runtime_error(
      "join needs CycloneDDS (Debian package cyclonedds-dev), without which this program was "
      "built");
#endif
}

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
        link_(openLink(run.args)),
        exchange_(run.args.robot, *link_, run.args.journal),
        view_(run.args.robot, run.options) {
    if (run.args.maps.empty()) return;
    live_.emplace(run.args.maps.front());
    exchange_.askForOutlinesFirst();
  }

  /** Stays in the team until the arguments or a signal say so. */
  void stay() {
    const auto end = Clock::now() + std::chrono::duration<double>(run_.args.seconds);
    do {
      if (live_ && reading_.isDue()) read();
      is_new_ = exchange_.step() || is_new_;
      if (exchange_.hasTwin()) meetTwin();
      think();
      if (status_.isDue()) tell();
      link_->wait(exchange_.isWaiting() ? kWaitingToSend : kWaiting);
    } while (!stopWanted() && !isComplete() && (run_.args.seconds <= 0 || Clock::now() < end));
    if (thinking_.valid()) take(thinking_.get());
    if (isComplete()) sayFarewell();
    tell();
  }

  /** True if all robots whose maps are known have joined. */
  bool allJoined() const {
    const auto& members = run_.report.members;
    return std::all_of(members.begin(), members.end(), [](const auto& m) { return m.joined; });
  }

 private:
  void meetTwin() {
    const std::string text =
        "another robot of this domain has the name " + mrpt::fusion::printable(run_.args.robot);
    if (Clock::now() - begin_ < kNewcomer)
      throw std::runtime_error(text + ": each robot needs a name of its own");
    note(text);
  }

  void read() {
    const auto map = live_->readIfChanged(run_);
    if (!map) return;
    exchange_.publish(map);
    is_new_ = true;
  }

  /** Fuses in another thread, so that the link is never left alone. */
  void think() {
    if (thinking_.valid()) {
      if (thinking_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
      take(thinking_.get());
    }
    if (!is_new_) return;
    is_new_ = false;
    std::vector<mrpt::fusion::MapSnapshot> maps;
    for (const auto& map : exchange_.maps()) maps.emplace_back(map.second);
    run_.startStep();
    thinking_ = std::async(std::launch::async, [this, maps] { return view_.update(maps); });
  }

  void take(TeamKnowledge known) {
    for (const std::string& text : known.notes) note(text);
    exchange_.want(known.wanted);
    const bool is_new = known.state && known.state->map && known.state != known_.state;
    known_ = std::move(known);
    if (is_new) save();
  }

  /** Notes what is wrong, once. */
  void note(const std::string& text) {
    if (notes_.size() < kMostNotes && notes_.insert(text).second) run_.note(text);
  }

  /** Writes all outputs. */
  void save() {
    const auto& state = *known_.state;
    run_.report.members = state.members;
    run_.report.pairs = state.pairs;
    run_.report.maps.clear();
    std::vector<Robot> robots;
    for (const auto& map : known_.maps) {
      Robot& robot = robots.emplace_back();
      robot.name = map.robot;
      robot.map.octree = map.map.octree();
      run_.report.maps.push_back(mrpt::fusion::reportOn(map.robot, map.robot, *map.map.octree()));
      run_.report.maps.back().sources = map.map.sources();
    }
    const auto joined = std::count_if(state.members.begin(), state.members.end(),
                                      [](const FusionMember& m) { return m.joined; });
    run_.endStep("fuse");
    if (joined < 2) return;
    if (!run_.args.output.empty()) saveFused(run_, state.map, state.sources);
    savePoses(run_, true);
    drawTeamPage(run_, robots, state.map);
    run_.saveReports();
  }

  bool isComplete() const {
    const size_t wanted = run_.args.until_complete;
    if (wanted == 0 || known_.whole_maps < wanted) return false;
    if (thinking_.valid() || is_new_) return false;
    const auto& own = exchange_.maps().at({run_.args.robot, {}});
    const auto& acknowledged = exchange_.acknowledged();
    const auto know = std::count_if(acknowledged.begin(), acknowledged.end(), [&](const auto& a) {
      return a.second == own.completeVersion();
    });
    return !live_ || static_cast<size_t>(know) + 1 >= wanted;
  }

  /** Sends what still waits, as what this robot has. If nobody is there, it soon gives up. */
  void sayFarewell() {
    const auto end = Clock::now() + kFarewell;
    while (exchange_.isWaiting() && Clock::now() < end) {
      exchange_.step();
      link_->wait(kWaitingToSend);
    }
  }

  /** Prints one line if it is another line than before. */
  void tell() {
    if (const std::string reason = exchange_.takeReason(); !reason.empty())
      note("samples are refused: " + reason);
    std::string line;
    const auto add = [&](const std::string& text) { line += (line.empty() ? "" : " | ") + text; };
    for (const auto& [source, map] : exchange_.maps()) add(textOf(source, map));
    for (const auto& m : known_.meetings) add(textOf(m));
    if (known_.state) add(fusedText());
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
  std::string fusedText() const {
    std::string names;
    for (const FusionMember& m : known_.state->members) {
      if (!m.joined) continue;
      names += " " + m.robot;
      if (const auto part = known_.parts.find(m.robot); part != known_.parts.end())
        names += " (" + std::to_string(part->second) + " bytes of it)";
    }
    return "fused" + names;
  }

  RunContext& run_;
  const Clock::time_point begin_ = Clock::now();
  std::unique_ptr<mrpt::fusion::Link> link_;
  mrpt::fusion::TeamExchange exchange_;
  mrpt::fusion::TeamView view_;  // of the thread that fuses
  std::optional<LiveMap> live_;
  std::future<TeamKnowledge> thinking_;
  TeamKnowledge known_;
  bool is_new_ = true;  // true if the maps have changed since the last fusion began
  Timer reading_{kReadingPeriod}, status_{kStatusPeriod};
  std::string last_line_;
  std::set<std::string> notes_;  // that were printed
};

}  // namespace

bool runJoin(RunContext& run) {
  stopAtSignals();
  choosePolicy(run);
  Member member(run);
  member.stay();
  return member.allJoined();
}

}  // namespace map_fusion
