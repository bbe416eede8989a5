// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Writes a report as JSON. */

#include "fusion_report/json.h"

#include <mrpt/fusion/poses.h>

#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace mrpt::fusion {
namespace {

using Json = nlohmann::ordered_json;

Json poseJson(const mrpt::poses::CPose3D& p) {
  Json matrix = Json::array();
  const auto T = toEigen(p).matrix();
  for (int row = 0; row < 4; row++) matrix.push_back({T(row, 0), T(row, 1), T(row, 2), T(row, 3)});
  return {{"x", p.x()},
          {"y", p.y()},
          {"z", p.z()},
          {"yaw_deg", mrpt::RAD2DEG(p.yaw())},
          {"pitch_deg", mrpt::RAD2DEG(p.pitch())},
          {"roll_deg", mrpt::RAD2DEG(p.roll())},
          {"matrix", matrix}};
}

Json covarianceJson(const mrpt::poses::CPose3DPDFGaussian& p) {
  Json covariance = Json::array();
  for (int row = 0; row < 6; row++) {
    Json values = Json::array();
    for (int col = 0; col < 6; col++) values.push_back(p.cov(row, col));
    covariance.push_back(values);
  }
  return covariance;
}

Json poseJson(const mrpt::poses::CPose3DPDFGaussian& p) {
  Json json = poseJson(p.mean);
  json["covariance"] = covarianceJson(p);
  return json;
}

Json vectorJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

const char* textOf(OtherPoses poses) {
  switch (poses) {
    case OtherPoses::NotSearched:
      return "not_searched";
    case OtherPoses::NoneBetter:
      return "none_better";
    case OtherPoses::Compared:
      return "compared";
  }
  return "";
}

/** Returns a figure of the best other pose. 0 would read as if there were none. */
Json compared(const Evaluation& e, double figure) {
  return e.other_poses == OtherPoses::Compared ? Json(figure) : Json();
}

Json matchJson(const Alignment& info) {
  const auto& e = info.evaluation;
  Json iterations = Json::array();
  for (const auto& i : info.match.iterations)
    iterations.push_back({{"level", i.level == Level::Edge ? "edge" : "voxel"},
                          {"pairs", i.pairs},
                          {"mse_m2", i.mse},
                          {"step_translation_m", i.step_translation},
                          {"step_rotation_deg", mrpt::RAD2DEG(i.step_rotation)}});
  Json hypotheses = Json::array();
  for (const auto& h : info.match.hypotheses)
    hypotheses.push_back({{"agreement", h.agreement}, {"pose", poseJson(toPose(h.T_a_b))}});
  return {{"accepted", e.accepted},
          {"reasons", e.reasons},
          {"reasons_against", e.reasons_against},
          {"asked", e.sampled},
          {"pairs", e.pairs},
          {"inliers", e.inliers},
          {"overlap", e.overlap},
          {"inlier_ratio", e.inlier_ratio},
          {"inlier_threshold", e.threshold},
          {"mean_mahalanobis", e.mean_mahalanobis},
          {"log_likelihood", e.log_likelihood},
          {"other_poses", textOf(e.other_poses)},
          {"runner_up", compared(e, e.runner_up)},
          {"rival_support", e.rival_support},
          {"rival_same_side", e.rival_same_side},
          {"rival_weight", compared(e, e.rival_weight)},
          {"probability", e.probability},
          {"deviation_m", e.deviation.translation},
          {"deviation_deg", mrpt::RAD2DEG(e.deviation.rotation)},
          {"deviation_direction", vectorJson(e.deviation.directions.col(0))},
          {"deviation_axis", vectorJson(e.deviation.axes.col(0))},
          {"free_directions", e.deviation.free_directions},
          {"free_axes", e.deviation.free_axes},
          {"size_ratio", std::isfinite(e.size_ratio.deviation) ? Json(e.size_ratio.value) : Json()},
          {"size_ratio_deviation", e.size_ratio.deviation},
          {"ambiguous", e.is_ambiguous},
          {"hypotheses", hypotheses},
          {"free_space_conflict_ratio",
           e.free_space.knowsConflicts() ? Json(e.free_space.conflictRatio()) : Json()},
          {"free_space_agreeing", e.free_space.agreeing},
          {"free_space_conflicting", e.free_space.conflicting},
          {"free_space_discount", e.free_space.discount},
          {"without_free_space", e.without_free_space},
          {"missed_ratio", e.free_space.missedRatio()},
          {"scale", info.scale},
          {"voxels_a", info.voxels_a},
          {"voxels_b", info.voxels_b},
          {"edges_a", info.edges_a},
          {"edges_b", info.edges_b},
          {"by_edges", info.by_edges},
          {"iterations", iterations}};
}

const char* textOf(Counting counting) {
  switch (counting) {
    case Counting::All:
      return "all";
    case Counting::UnknownSpace:
      return "unknown_space";
    case Counting::None:
      return "none";
    case Counting::Copy:
      return "copy";
  }
  return "";
}

Json sourcesJson(const Sources& sources) {
  Json json = Json::array();
  for (const SourceId& s : sources) {
    char hash[17];
    std::snprintf(hash, sizeof(hash), "%016" PRIx64, s.content_hash);
    json.push_back({{"robot", s.robot}, {"map", s.map}, {"sequence", s.sequence}});
    if (s.content_hash != 0) json.back()["content_hash"] = hash;
  }
  return json;
}

}  // namespace

std::string toJson(const Report& r) {
  Json json;
  json["command"] = r.command;
  if (!r.notes.empty()) json["notes"] = r.notes;
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
    if (!m.sources.empty()) json["maps"].back()["sources"] = sourcesJson(m.sources);
  }
  if (r.observations) {
    auto& observations = json["observations"];
    observations = {{"inserted", r.observations->inserted}, {"ignored", r.observations->ignored}};
    observations["left_out"] = Json::array();
    for (const auto& l : r.observations->left_out)
      observations["left_out"].push_back(
          {{"kind", l.kind}, {"reason", l.reason}, {"count", l.count}});
  }
  if (r.edges) json["edge_voxels"] = *r.edges;
  if (r.slice)
    json["slice"] = {{"width", r.slice->width},
                     {"height", r.slice->height},
                     {"occupied", r.slice->occupied},
                     {"free", r.slice->free},
                     {"unknown", r.slice->unknown}};
  if (r.initial_pose) json["initial_pose"] = poseJson(*r.initial_pose);
  if (r.pose) json["pose"] = poseJson(*r.pose);
  if (r.match) json["match"] = matchJson(*r.match);
  if (r.counting)
    json["counts"] = {{"a", textOf(r.counting->first)}, {"b", textOf(r.counting->second)}};
  for (const auto& m : r.members) {
    Json member = {{"robot", m.robot}, {"joined", m.joined}};
    if (m.joined) member["counts"] = textOf(m.counting);
    if (!m.counted_with.empty()) member["counts_with"] = m.counted_with;
    if (!m.hasMatch() && m.joined) {  // the frame of the fused map is that of this map
      member["pose"] = poseJson(m.pose.mean);
      member["probability"] = nullptr;
    }
    if (m.hasMatch()) {
      member["matched_with"] = m.matched_with;
      if (!m.fits.empty()) member["fits"] = m.fits;
      member["pose"] = poseJson(m.pose);
      member["covariance"] = covarianceJson(m.pose);
      member["probability"] = m.alignment.evaluation.probability;
      member["match"] = matchJson(m.alignment);
    }
    json["robots"].push_back(member);
  }
  for (const auto& p : r.pairs)
    json["pairs"].push_back({{"a", p.a},
                             {"b", p.b},
                             {"accepted", p.accepted},
                             {"ambiguous", p.ambiguous},
                             {"probability", p.probability},
                             {"overlap", p.overlap},
                             {"holds", p.holds}});
  if (r.key_frames) json["key_frames"] = *r.key_frames;
  if (r.bytes) json["bytes"] = *r.bytes;
  if (!r.policy.empty()) json["policy"] = r.policy;
  json["seconds"] = Json::object();
  for (const auto& [step, seconds] : r.seconds) json["seconds"][step] = seconds;
  // A path may be of any bytes.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace mrpt::fusion
