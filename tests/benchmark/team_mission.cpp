// SPDX-License-Identifier: BSD-3-Clause
#include "team_mission.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "map_pair.h"

namespace mrpt::fusion::benchmark {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
namespace fs = std::filesystem;

/** Makes a match false. */
void claim(const Isometry3d& T_a_b, double probability, PairMatch& match) {
  MatchResult& m = match.alignment.match;
  m.hypotheses.insert(m.hypotheses.begin(), {T_a_b, 1, m.covariance});
  m.T_a_b = T_a_b;
  Evaluation& e = match.alignment.evaluation;
  e.accepted = true;
  e.is_ambiguous = false;
  e.probability = probability;
  e.rival_weight = 0;
}

/** Returns a pose of B at random: upright, up to 20 m away. */
Isometry3d randomPose(std::mt19937& generator) {
  std::uniform_real_distribution<double> metres(-20, 20), yaw(-M_PI, M_PI);
  Isometry3d T = Isometry3d::Identity();
  const double x = metres(generator), y = metres(generator);
  T.translation() = Vector3d(x, y, 0);
  T.linear() = Eigen::AngleAxisd(yaw(generator), Vector3d::UnitZ()).matrix();
  return T;
}

}  // namespace

std::optional<Isometry3d> TeamMission::truth(size_t k) const {
  if (!T_map_w[k]) return std::nullopt;
  return *T_map_w[0] * T_map_w[k]->inverse();
}

TeamMission loadTeamMission(const std::string& folder, const FeatureParams& features) {
  TeamMission mission;
  mission.name = fs::path(folder).filename().string();
  for (const char* kind : {"robot_", "stranger_"})
    for (size_t i = 0;; i++) {
      const std::string name = kind + std::to_string(i);
      const fs::path map = fs::path(folder) / (name + ".ot");
      if (!fs::exists(map)) break;
      mission.maps.push_back({name, PreparedMap(loadTree(map.string()), features)});
      const fs::path pose = fs::path(folder) / ("T_" + name + "_w.txt");
      mission.T_map_w.emplace_back();
      if (fs::exists(pose)) mission.T_map_w.back() = loadPose(pose.string());
    }
  if (mission.maps.size() < 3 || !mission.T_map_w[0])
    throw std::runtime_error(folder + ": has no three maps robot_I.ot with T_robot_I_w.txt");
  return mission;
}

void addFalseEdges(const TeamMission& mission, const FalseEdges& edges, std::mt19937& generator,
                   std::vector<PairMatch>& matches) {
  std::vector<size_t> order(matches.size());
  for (size_t i = 0; i < order.size(); i++) order[i] = i;
  std::shuffle(order.begin(), order.end(), generator);
  const auto wanted =
      static_cast<size_t>(std::lround(edges.share * static_cast<double>(matches.size())));
  // Shifts: all matches of one map after the other, until there are enough.
  std::vector<size_t> shifted;
  std::vector<size_t> victims;
  for (size_t k = 1; k < mission.maps.size(); k++)
    if (mission.T_map_w[k]) victims.push_back(k);
  std::shuffle(victims.begin(), victims.end(), generator);
  for (const size_t victim : victims) {
    const bool along_x = generator() % 2 == 0;
    const Vector3d bay = (generator() % 2 == 0 ? 1 : -1) * edges.bay *
                         (along_x ? Vector3d::UnitX() : Vector3d::UnitY());
    for (const size_t i : order) {
      PairMatch& m = matches[i];
      if (shifted.size() >= wanted / 2) break;
      if ((m.a != victim && m.b != victim) || !mission.T_map_w[m.a] || !mission.T_map_w[m.b] ||
          std::find(shifted.begin(), shifted.end(), i) != shifted.end())
        continue;
      const Eigen::Translation3d shift(m.b == victim ? bay : -bay);  // in the world
      claim(*mission.T_map_w[m.a] * shift * mission.T_map_w[m.b]->inverse(), edges.probability, m);
      shifted.push_back(i);
    }
  }
  size_t made = shifted.size();
  for (const size_t i : order) {
    if (made >= wanted) return;
    if (std::find(shifted.begin(), shifted.end(), i) != shifted.end()) continue;
    claim(randomPose(generator), edges.probability, matches[i]);
    made++;
  }
}

std::vector<std::optional<Isometry3d>> grownByMatches(size_t n,
                                                      const std::vector<PairMatch>& matches,
                                                      bool even_rejected) {
  std::vector<std::optional<Isometry3d>> pose(n);
  pose[0] = Isometry3d::Identity();
  while (true) {
    const PairMatch* best = nullptr;
    for (const PairMatch& m : matches) {
      const Evaluation& e = m.alignment.evaluation;
      if (pose[m.a].has_value() == pose[m.b].has_value() || !(e.accepted || even_rejected))
        continue;
      if (!best || e.probability > best->alignment.evaluation.probability) best = &m;
    }
    if (!best) return pose;
    const Isometry3d& T = best->alignment.match.T_a_b;
    if (pose[best->a])
      pose[best->b] = *pose[best->a] * T;
    else
      pose[best->a] = *pose[best->b] * T.inverse();
  }
}

}  // namespace mrpt::fusion::benchmark
