// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Collects what the picture of a page shows. modules/fusion_report/page/web reads it. */

#include <mrpt/fusion/poses.h>
#include <mrpt/fusion/voxels.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "fusion_report/page/base64.h"
#include "fusion_report/page/conflicts.h"
#include "fusion_report/page/cubes.h"
#include "fusion_report/page/graph.h"
#include "fusion_report/page/page.h"
#include "fusion_team/graph/joint_verdict.h"

namespace mrpt::fusion {
namespace {

using Json = nlohmann::ordered_json;

/** Largest numbers of the drawn. A cube is about 1.8 bytes of the page. */
constexpr size_t kMostCubesOfMaps = 360'000, kMostCubesOfFused = 240'000, kMostFree = 120'000,
                 kMostConflicts = 40'000, kMostEdges = 20'000, kMostPairs = 5000, kMostRivals = 24;

Json poseJson(const Eigen::Isometry3d& T) {
  Json numbers = Json::array();
  for (int row = 0; row < 3; row++)
    for (int col = 0; col < 4; col++) numbers.push_back(T.matrix()(row, col));
  return numbers;
}

/** Returns the number of finest voxels in cubes. */
double voxelsOf(const PageCubes& cubes) {
  double n = 0;
  for (const PageCube& c : cubes.cubes) n += std::pow(c.cube.side(), 3);
  return n;
}

Json cubesJson(const PageCubes& all, size_t most, bool are_masks = false) {
  const double voxels = voxelsOf(all);
  const PageCubes cubes = coarsened(all, most, are_masks);
  const PackedCubes bytes = packed(cubes);
  return {{"resolution", cubes.resolution},
          {"count", voxels},
          {"drawn", cubes.cubes.size()},
          {"tree", toBase64(bytes.tree)},
          {"values", toBase64(bytes.values)}};
}

void append(std::string& bytes, unsigned word) {
  bytes += static_cast<char>(word & 0xffU);
  bytes += static_cast<char>(word >> 8U & 0xffU);
}

void append(std::string& bytes, const octomap::OcTreeKey& key) {
  for (unsigned axis = 0; axis < 3; axis++) append(bytes, key[axis]);
}

/** Returns every \a stride -th of n elements, so that at most \a most are left. */
size_t strideOf(size_t n, size_t most) { return std::max<size_t>(1, (n + most - 1) / most); }

Json edgesJson(const EdgeVoxels& edges) {
  std::string keys, directions;
  for (size_t i = 0; i < edges.size(); i += strideOf(edges.size(), kMostEdges)) {
    const Eigen::Vector3d tau = edges.covariance[i].direction();
    for (int axis = 0; axis < 3; axis++) {
      const double key =
          std::floor(edges.centre[i].cast<double>()[axis] / edges.resolution) + 32768;
      append(keys, static_cast<unsigned>(std::clamp(key, 0.0, 65535.0)));
      directions += static_cast<char>(std::lround(127 * std::clamp(tau[axis], -1.0, 1.0)));
    }
  }
  return {{"resolution", edges.resolution},
          {"count", edges.size()},
          {"keys", toBase64(keys)},
          {"directions", toBase64(directions)}};
}

/** Returns the matched pairs by the keys of their voxels: inliers and the other pairs. */
Json pairsJson(const Alignment& match, const PageScene& scene) {
  const OccupiedVoxels a = extractOccupiedVoxels(*scene.maps[0].octree),
                       b = extractOccupiedVoxels(*scene.maps[1].octree);
  const Pairs& pairs = match.match.pairs;
  std::string inliers, outliers;
  for (size_t i = 0; i < pairs.size(); i += strideOf(pairs.size(), kMostPairs)) {
    const Pair& p = pairs[i];
    if (p.a >= a.size() || p.b >= b.size()) continue;
    const double d =
        mahalanobisDistance(p.squared_distance, a.probability[p.a], b.probability[p.b]);
    std::string& bytes = d < scene.limits.inlier_mahalanobis ? inliers : outliers;
    append(bytes, a.key[p.a]);
    append(bytes, b.key[p.b]);
  }
  return {
      {"count", pairs.size()}, {"inliers", toBase64(inliers)}, {"outliers", toBase64(outliers)}};
}

/** Appends the rivals of a match: the best rival, and others that agree at least a little.
 * \param[in] T_a Pose of the match's map A in the picture. */
void addRivals(const Alignment& match, size_t map, const Eigen::Isometry3d& T_a, Json& rivals) {
  constexpr double kLeastAgreement = 0.01;
  const auto& all = match.match.hypotheses;
  for (size_t i = 1; i < std::min(all.size(), kMostRivals); i++) {
    const double agreement = all[0].agreement > 0 ? all[i].agreement / all[0].agreement : 0;
    if (i == 1 || agreement >= kLeastAgreement)
      rivals.push_back({{"map", map},
                        {"rank", i},
                        {"agreement", agreement},
                        {"pose", poseJson(T_a * all[i].T_a_b)}});
  }
}

std::optional<size_t> indexOf(const std::string& name, const PageScene& scene) {
  for (size_t i = 0; i < scene.maps.size(); i++)
    if (scene.maps[i].name == name) return i;
  return std::nullopt;
}

Json rivalsJson(const Report& report, const PageScene& scene) {
  Json rivals = Json::array();
  if (report.match && scene.maps.size() == 2)
    addRivals(*report.match, 1, scene.maps[0].pose, rivals);
  for (size_t i = 0; i < std::min(report.members.size(), scene.maps.size()); i++)
    if (const auto a = indexOf(report.members[i].matched_with, scene))
      addRivals(report.members[i].alignment, i, scene.maps[*a].pose, rivals);
  return rivals;
}

/** Returns the shown maps other than the i-th, as seen from it. */
std::vector<OtherMap> othersOf(size_t i, const PageScene& scene) {
  std::vector<OtherMap> others;
  for (size_t k = 0; k < scene.maps.size(); k++)
    if (k != i && scene.maps[k].is_shown)
      others.push_back(
          {scene.maps[k].octree.get(), scene.maps[k].pose.inverse() * scene.maps[i].pose});
  return others;
}

Json graphJson(const TeamPicture& graph) {
  Json nodes = Json::array(), links = Json::array();
  for (const auto& n : graph.nodes) {
    nodes.push_back({{"map", n.map}, {"at", {n.at.x(), n.at.y(), n.at.z()}}});
    if (!n.half_axes) continue;
    Json axes = Json::array();
    for (int row = 0; row < 3; row++)
      for (int col = 0; col < 3; col++) axes.push_back((*n.half_axes)(row, col));
    nodes.back()["axes"] = axes;
  }
  for (const auto& l : graph.links)
    links.push_back({{"a", l.a}, {"b", l.b}, {"verdict", l.verdict}});
  return {{"nodes", nodes}, {"links", links}, {"enlarged", graph.enlarged}};
}

Json mapJson(const PageScene& scene, size_t i) {
  const PageMap& map = scene.maps[i];
  Json json = {
      {"name", map.name}, {"colour", i}, {"shown", map.is_shown}, {"pose", poseJson(map.pose)}};
  const PageCubes cubes = occupiedCubes(*map.octree);
  json["occupied"] = cubesJson(cubes, kMostCubesOfMaps / scene.maps.size());
  json["count"] = json["occupied"]["count"];
  if (map.edges) json["edges"] = edgesJson(*map.edges);
  if (scene.kind != PageScene::Kind::Maps && map.is_shown)
    json["conflicts"] =
        cubesJson(conflictingCubes(*map.octree, othersOf(i, scene)), kMostConflicts);
  if (!scene.fused && map.is_shown)
    json["free"] = cubesJson(boundaryOfFreeSpace(*map.octree), kMostFree / scene.maps.size(), true);
  return json;
}

}  // namespace

std::string toSceneJson(const Report& report, const PageScene& scene) {
  static constexpr const char* kKinds[] = {"maps", "pair", "team"};
  const EvaluationParams& limits = scene.limits;
  Json json = {{"kind", kKinds[static_cast<size_t>(scene.kind)]},
               {"limits",
                {{"min_overlap", limits.min_overlap},
                 {"max_free_conflict", limits.max_free_conflict},
                 {"max_runner_up", limits.max_runner_up},
                 {"max_team_runner_up", JointVerdictParams().max_runner_up},
                 {"min_probability", limits.min_probability}}},
               {"maps", Json::array()}};
  for (size_t i = 0; i < scene.maps.size(); i++) json["maps"].push_back(mapJson(scene, i));
  if (scene.fused) {
    const PageCubes cubes = occupiedCubes(*scene.fused);
    json["fused"] = {{"occupied", cubesJson(cubes, kMostCubesOfFused)},
                     {"free", cubesJson(boundaryOfFreeSpace(*scene.fused), kMostFree, true)}};
    json["fused"]["count"] = json["fused"]["occupied"]["count"];
  }
  if (report.match && !report.match->by_edges && !report.match->match.pairs.empty())
    json["pairs"] = pairsJson(*report.match, scene);
  json["rivals"] = rivalsJson(report, scene);
  json["graph"] = graphJson(pictureOf(report, scene));
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace mrpt::fusion
