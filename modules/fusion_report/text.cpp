// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Prints a report as text. */

#include "fusion_report/text.h"

#include <mrpt/fusion/poses.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <ostream>
#include <string>

#include "fusion_base/percent_text.h"
#include "fusion_base/printable.h"

namespace mrpt::fusion {
namespace {

__attribute__((format(printf, 2, 3))) void line(std::ostream& out, const char* format, ...) {
  char text[512];
  va_list args;
  va_start(args, format);
  std::vsnprintf(text, sizeof(text), format, args);
  va_end(args);
  out << printable(text) << "\n";  // names of robots and files are from outside
}

/** Returns the number of characters of a printable text, which is UTF-8. */
size_t charactersOf(const std::string& text) {
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80;
  }));
}

/** A column of names. Very long names move the columns behind them. */
class NameColumn {
 public:
  explicit NameColumn(size_t least) : width_(least) {}
  void makeRoomFor(const std::string& name) {
    constexpr size_t kWidest = 40;
    width_ = std::max(width_, std::min(charactersOf(printable(name)), kWidest));
  }
  int width() const { return static_cast<int>(width_); }
  /** Returns a name as it is printed, filled up with blanks. */
  std::string of(const std::string& name) const {
    const std::string shown = printable(name);
    const size_t characters = charactersOf(shown);
    return shown + std::string(width_ - std::min(width_, characters), ' ');
  }

 private:
  size_t width_;
};

void printMaps(const Report& r, std::ostream& out) {
  NameColumn names(12);
  for (const auto& m : r.maps) names.makeRoomFor(m.role);
  const int w = names.width();
  line(out, "%-*s   voxel   occupied       free   mean entropy (nats)   size", w + 2, "maps");
  line(out, "%-*s       m     voxels     voxels   occupied    known     m", w + 2, "");
  for (const auto& m : r.maps) {
    const auto& s = m.statistics;
    line(out, "  %s %7.3f %10zu %10zu   %8.4f %8.4f     %.1f x %.1f x %.1f",
         names.of(m.role).c_str(), m.resolution, s.occupied, s.free, s.mean_entropy_occupied,
         s.mean_entropy_known, m.high[0] - m.low[0], m.high[1] - m.low[1], m.high[2] - m.low[2]);
  }
  for (const auto& m : r.maps) {
    if (m.sources.size() < 2) continue;
    std::string sources;
    for (const SourceId& s : m.sources)
      sources += (sources.empty() ? "" : ", ") + (s.robot.empty() ? s.map : s.robot);
    line(out, "sources of %s: %s", m.role.c_str(), sources.c_str());
  }
}

const char* verdictOf(const Evaluation& e) {
  return e.accepted ? "accepted" : e.is_ambiguous ? "AMBIGUOUS" : "REJECTED";
}

/** Prints the reasons of a verdict, each with its sign: those against the pose are first. */
void printReasons(const Evaluation& e, std::ostream& out) {
  for (size_t i = 0; i < e.reasons.size(); i++)
    out << std::string(kValueColumn, ' ') << (i < e.reasons_against ? "- " : "+ ")
        << printable(e.reasons[i]) << "\n";
}

void printMember(const FusionMember& m, const NameColumn& names, std::ostream& out) {
  const std::string name = names.of(m.robot);
  if (!m.hasMatch()) return line(out, "%s first map, its frame is kept", name.c_str());
  const auto& e = m.alignment.evaluation;
  const std::string sure = m.alignment.by_edges ? "" : ", probability " + percent(e.probability);
  line(out, "%s %s%s, pose %s, overlap %.1f %%%s", name.c_str(),
       m.alignment.by_edges ? "placed by edges" : verdictOf(e),
       m.joined && !e.accepted ? ", forced" : "", poseText(m.pose.mean).c_str(), 100 * e.overlap,
       sure.c_str());
  if (!m.alignment.by_edges) printReasons(e, out);
}

void printMatch(const Alignment& info, std::ostream& out) {
  const auto& e = info.evaluation;
  size_t edge_iterations = 0;
  for (const auto& i : info.match.iterations) edge_iterations += i.level == Level::Edge ? 1 : 0;
  if (!info.match.iterations.empty()) {
    line(out, "edges compared   %zu of A, %zu of B", info.edges_a, info.edges_b);
    line(out, "iterations       %zu on edges, %zu on voxels", edge_iterations,
         info.match.iterations.size() - edge_iterations);
  }
  line(out, "overlap          %.1f %%  (mean of both maps; of B: %zu of %zu sampled voxels paired)",
       100 * e.overlap, e.pairs, e.sampled);
  line(out, "inlier ratio     %.1f %%  (threshold %.1f %%)", 100 * e.inlier_ratio,
       100 * e.threshold);
  if (e.free_space.knowsConflicts())
    line(out, "conflict ratio   %.1f %%  (obstacles in seen free space of the other map)",
         100 * e.free_space.conflictRatio());
  else
    line(out,
         "conflict ratio   unknown  (nothing to compare: no obstacle lies where the other map is "
         "free)");
  if (e.other_poses == OtherPoses::NotSearched) line(out, "other poses      were not searched");
  if (e.other_poses == OtherPoses::NoneBetter)
    line(out, "other poses      a search everywhere found no pose that agrees clearly better");
  line(out, "verdict          %s", verdictOf(e));
  printReasons(e, out);
  if (e.is_ambiguous)
    line(out, "rival pose       %s", poseText(toPose(info.match.hypotheses[1].T_a_b)).c_str());
}

}  // namespace

std::string poseText(const mrpt::poses::CPose3D& p) {
  char text[160];
  std::snprintf(text, sizeof(text), "[%.4f %.4f %.4f %.3f %.3f %.3f]", p.x(), p.y(), p.z(),
                mrpt::RAD2DEG(p.yaw()), mrpt::RAD2DEG(p.pitch()), mrpt::RAD2DEG(p.roll()));
  return text;
}

void print(const Report& r, std::ostream& out) {
  if (!r.maps.empty()) printMaps(r, out);
  if (r.observations) {
    line(out, "observations     %zu inserted, %zu left out", r.observations->inserted,
         r.observations->ignored);
    for (const auto& l : r.observations->left_out)
      line(out, "                 - %zu %s: %s", l.count, l.kind.c_str(), l.reason.c_str());
  }
  if (r.edges) line(out, "edge voxels      %zu", *r.edges);
  if (r.slice)
    line(out, "slice            %zu x %zu cells: %zu occupied, %zu free, %zu unknown",
         r.slice->width, r.slice->height, r.slice->occupied, r.slice->free, r.slice->unknown);
  if (r.initial_pose) line(out, "initial guess    %s", poseText(*r.initial_pose).c_str());
  if (r.pose)
    line(out, "pose of B in A   %s  (m, deg: x y z yaw pitch roll)",
         poseText(r.pose->mean).c_str());
  if (r.match) printMatch(*r.match, out);
  NameColumn names(kValueColumn - 1);
  for (const auto& member : r.members) names.makeRoomFor(member.robot);
  for (const auto& member : r.members) printMember(member, names, out);
  if (r.key_frames) line(out, "joined           %zu key frames", *r.key_frames);
  if (r.bytes) line(out, "size             %zu bytes", *r.bytes);
  if (!r.policy.empty()) line(out, "merged by        %s", r.policy.c_str());
  out << "seconds         ";
  double total = 0;
  for (const auto& [step, seconds] : r.seconds) {
    char text[64];
    std::snprintf(text, sizeof(text), " %s %.2f,", step.c_str(), seconds);
    out << text;
    total += seconds;
  }
  line(out, " total %.2f", total);
}

}  // namespace mrpt::fusion
