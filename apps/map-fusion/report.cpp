// SPDX-License-Identifier: BSD-3-Clause
#include "report.h"

#include <mrpt/fusion/poses.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <ostream>

#include "fusion_octree/walk.h"

using Json = nlohmann::ordered_json;

namespace {

__attribute__((format(printf, 2, 3))) void line(std::ostream& out, const char* format, ...) {
  char text[512];
  va_list args;
  va_start(args, format);
  std::vsnprintf(text, sizeof(text), format, args);
  va_end(args);
  out << text << "\n";
}

std::string poseText(const mrpt::poses::CPose3D& p) {
  char text[160];
  std::snprintf(text, sizeof(text), "[%.4f %.4f %.4f %.3f %.3f %.3f]", p.x(), p.y(), p.z(),
                mrpt::RAD2DEG(p.yaw()), mrpt::RAD2DEG(p.pitch()), mrpt::RAD2DEG(p.roll()));
  return text;
}

void printMaps(const Report& r, std::ostream& out) {
  out << "maps             voxel   occupied       free   mean entropy (nats)   size\n"
      << "                     m     voxels     voxels   occupied    known     m\n";
  for (const auto& m : r.maps) {
    const auto& s = m.statistics;
    line(out, "  %-12s %7.3f %10zu %10zu   %8.4f %8.4f     %.1f x %.1f x %.1f", m.role.c_str(),
         m.resolution, s.occupied, s.free, s.mean_entropy_occupied, s.mean_entropy_known,
         m.high[0] - m.low[0], m.high[1] - m.low[1], m.high[2] - m.low[2]);
  }
}

const char* verdictOf(const mrpt::fusion::Evaluation& e) {
  return e.accepted ? "accepted" : e.is_ambiguous ? "AMBIGUOUS" : "REJECTED";
}

void printMember(const mrpt::fusion::FusionMember& m, std::ostream& out) {
  if (!m.hasMatch()) return line(out, "%-16s the first map: its frame is kept", m.robot.c_str());
  const auto& e = m.info.evaluation;
  line(out, "%-16s %s%s, pose %s, overlap %.1f %%", m.robot.c_str(),
       m.info.by_edges ? "by its edges" : verdictOf(e), m.joined && !e.accepted ? ", forced" : "",
       poseText(m.pose.mean).c_str(), 100 * e.overlap);
  if (!m.info.by_edges)
    for (const auto& reason : e.reasons) out << "                 - " << reason << "\n";
}

void printMatch(const mrpt::fusion::Alignment& info, std::ostream& out) {
  const auto& e = info.evaluation;
  size_t edge_iterations = 0;
  for (const auto& i : info.match.iterations)
    edge_iterations += i.level == mrpt::fusion::Level::Edge ? 1 : 0;
  if (!info.match.iterations.empty()) {
    line(out, "edge voxels      %zu in a, %zu in b", info.edges_m1, info.edges_m2);
    line(out, "iterations       %zu on edges, %zu on voxels", edge_iterations,
         info.match.iterations.size() - edge_iterations);
  }
  line(out, "overlap          %.1f %%  (%zu of %zu voxels of b paired)", 100 * e.overlap, e.pairs,
       e.asked);
  line(out, "inlier ratio     %.1f %%  (threshold %.1f %%)", 100 * e.inlier_ratio,
       100 * e.threshold);
  line(out, "in free space    %.1f %%  of the obstacles seen by both",
       100 * e.free_space.conflictRatio());
  line(out, "verdict          %s", verdictOf(e));
  for (const auto& reason : e.reasons) out << "                 - " << reason << "\n";
  if (e.is_ambiguous)
    line(out, "rival pose       %s",
         poseText(mrpt::fusion::toPose(info.match.hypotheses[1].T_a_b)).c_str());
}

Json poseJson(const mrpt::poses::CPose3D& p) {
  Json matrix = Json::array();
  const auto T = mrpt::fusion::toEigen(p).matrix();
  for (int row = 0; row < 4; row++) matrix.push_back({T(row, 0), T(row, 1), T(row, 2), T(row, 3)});
  return {{"x", p.x()},
          {"y", p.y()},
          {"z", p.z()},
          {"yaw_deg", mrpt::RAD2DEG(p.yaw())},
          {"pitch_deg", mrpt::RAD2DEG(p.pitch())},
          {"roll_deg", mrpt::RAD2DEG(p.roll())},
          {"matrix", matrix}};
}

Json poseJson(const mrpt::poses::CPose3DPDFGaussian& p) {
  Json json = poseJson(p.mean);
  Json covariance = Json::array();
  for (int row = 0; row < 6; row++) {
    Json values = Json::array();
    for (int col = 0; col < 6; col++) values.push_back(p.cov(row, col));
    covariance.push_back(values);
  }
  json["covariance"] = covariance;
  return json;
}

Json matchJson(const mrpt::fusion::Alignment& info) {
  const auto& e = info.evaluation;
  Json iterations = Json::array();
  for (const auto& i : info.match.iterations)
    iterations.push_back({{"level", i.level == mrpt::fusion::Level::Edge ? "edge" : "voxel"},
                          {"pairs", i.pairs},
                          {"mse_m2", i.mse},
                          {"step_translation_m", i.step_translation},
                          {"step_rotation_deg", mrpt::RAD2DEG(i.step_rotation)}});
  Json hypotheses = Json::array();
  for (const auto& h : info.match.hypotheses)
    hypotheses.push_back(
        {{"agreement", h.agreement}, {"pose", poseJson(mrpt::fusion::toPose(h.T_a_b))}});
  return {{"accepted", e.accepted},
          {"reasons", e.reasons},
          {"asked", e.asked},
          {"pairs", e.pairs},
          {"inliers", e.inliers},
          {"overlap", e.overlap},
          {"inlier_ratio", e.inlier_ratio},
          {"inlier_threshold", e.threshold},
          {"mean_mahalanobis", e.mean_mahalanobis},
          {"log_likelihood", e.log_likelihood},
          {"runner_up", e.runner_up},
          {"probability", e.probability},
          {"deviation_m", e.deviation.translation},
          {"deviation_deg", mrpt::RAD2DEG(e.deviation.rotation)},
          {"ambiguous", e.is_ambiguous},
          {"hypotheses", hypotheses},
          {"free_space_conflict_ratio", e.free_space.conflictRatio()},
          {"free_space_agreeing", e.free_space.agreeing},
          {"free_space_conflicting", e.free_space.conflicting},
          {"voxels_a", info.voxels_m1},
          {"voxels_b", info.voxels_m2},
          {"edges_a", info.edges_m1},
          {"edges_b", info.edges_m2},
          {"by_edges", info.by_edges},
          {"iterations", iterations}};
}

}  // namespace

MapReport reportOn(const std::string& role, const std::string& path, const octomap::OcTree& map) {
  MapReport m;
  m.role = role;
  m.path = path;
  m.resolution = map.getResolution();
  m.nodes = map.size();
  if (map.size() > 0) {
    const Eigen::AlignedBox3d known = mrpt::fusion::knownSpace(map);
    std::copy_n(known.min().data(), 3, m.low);
    std::copy_n(known.max().data(), 3, m.high);
  }
  m.statistics = mrpt::fusion::statisticsOf(map);
  return m;
}

void print(const Report& r, std::ostream& out) {
  if (!r.maps.empty()) printMaps(r, out);
  if (r.observations)
    line(out, "observations     %zu inserted, %zu ignored", r.observations->first,
         r.observations->second);
  if (r.edges) line(out, "edge voxels      %zu", *r.edges);
  if (r.initial_pose) line(out, "initial guess    %s", poseText(*r.initial_pose).c_str());
  if (r.pose)
    line(out, "pose of b in a   %s  (m, deg: x y z yaw pitch roll)",
         poseText(r.pose->mean).c_str());
  if (r.match) printMatch(*r.match, out);
  for (const auto& member : r.members) printMember(member, out);
  if (r.bytes) line(out, "written          %zu bytes", *r.bytes);
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

std::string toJson(const Report& r) {
  Json json;
  json["command"] = r.command;
  json["maps"] = Json::array();
  for (const auto& m : r.maps) {
    const auto& s = m.statistics;
    json["maps"].push_back({{"role", m.role},
                            {"path", m.path},
                            {"resolution_m", m.resolution},
                            {"min_m", m.low},
                            {"max_m", m.high},
                            {"nodes", m.nodes},
                            {"occupied_voxels", s.occupied},
                            {"free_voxels", s.free},
                            {"mean_entropy_occupied_nats", s.mean_entropy_occupied},
                            {"mean_entropy_known_nats", s.mean_entropy_known}});
  }
  if (r.observations)
    json["observations"] = {{"inserted", r.observations->first},
                            {"ignored", r.observations->second}};
  if (r.edges) json["edge_voxels"] = *r.edges;
  if (r.initial_pose) json["initial_pose"] = poseJson(*r.initial_pose);
  if (r.pose) json["pose"] = poseJson(*r.pose);
  if (r.match) json["match"] = matchJson(*r.match);
  for (const auto& m : r.members) {
    Json member = {{"robot", m.robot}, {"joined", m.joined}};
    if (m.hasMatch()) {
      member["pose"] = poseJson(m.pose);
      member["match"] = matchJson(m.info);
    }
    json["robots"].push_back(member);
  }
  if (r.bytes) json["bytes"] = *r.bytes;
  if (!r.policy.empty()) json["policy"] = r.policy;
  json["seconds"] = Json::object();
  for (const auto& [step, seconds] : r.seconds) json["seconds"][step] = seconds;
  // A path may be of any bytes.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}
