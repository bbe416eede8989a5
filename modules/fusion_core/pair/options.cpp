// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/core/exceptions.h>
#include <mrpt/core/format.h>
#include <mrpt/fusion/options.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "fusion_base/config_check.h"

using namespace mrpt::fusion;

namespace {

/** One parameter: its key, meaning, range, and where it is. */
struct Entry {
  const char* key;
  const char* comment;
  double min, max;
  enum class Unit { Plain, Degrees, Count } unit;
  std::function<double()> get;
  std::function<void(double)> set;
};

/** The parameters that are numbers, in the order of the pipeline; what is listed here is loaded,
 * checked and saved. */
std::vector<Entry> entriesOf(Options& o) {
  std::vector<Entry> list;
  const auto add = [&](const char* key, auto& field, double min, double max, const char* comment,
                       Entry::Unit unit = Entry::Unit::Plain) {
    list.push_back({key, comment, min, max, unit, [&field] { return static_cast<double>(field); },
                    [&field](double v) { field = static_cast<std::decay_t<decltype(field)>>(v); }});
  };
  constexpr double kInf = 1e9;
  const auto deg = Entry::Unit::Degrees;
  const auto count = Entry::Unit::Count;
  auto& e = o.match.edges;
  add("normal_radius", e.normal_radius, 0, 100, "r_N of the normals' PCA, m");
  add("cost_radius", e.cost_radius, 0, 100, "r_N of the mean angle cost, eq. (5), m");
  add("min_normal_radius_voxels", e.min_normal_radius_voxels, 1, 20,
      "Least r_N of the normals' PCA, voxels");
  add("min_cost_radius_voxels", e.min_cost_radius_voxels, 1, 20,
      "Least r_N of the mean angle cost, voxels");
  add("max_surface_variation", e.max_surface_variation, 0, 1.0 / 3 + 1e-9,
      "Largest lambda_3 / (lambda_1+lambda_2+lambda_3) of a voxel with a normal; 1/3: any");
  add("min_surface_variation", e.min_surface_variation, 0, 1.0 / 3,
      "Least lambda_3 / (lambda_1+lambda_2+lambda_3) of an edge candidate");
  add("kappa", e.kappa, 0, 1, "Least mean angle cost of an edge candidate (Table I: 0.5)");
  add("trace_distance", e.trace_distance, 0, 100, "d_T of the walks along the surface, m");
  add("trace_step_deg", e.trace_step_angle, 0.1, 180, "Angle delta between walks, deg", deg);
  add("trace_window_deg", e.trace_window, 0, 90,
      "Walks leave across the edge, up to this far to either side, and along it; 90: anywhere, deg",
      deg);
  add("alpha_min_deg", e.alpha_min, 0, 180, "Least angle between two walks at an edge, deg", deg);
  add("alpha_max_deg", e.alpha_max, 0, 180, "Largest angle between two walks at an edge, deg", deg);
  add("outlier_neighbours", e.outlier_neighbours, 1, 1000,
      "Neighbours of the statistical outlier removal", count);
  add("outlier_deviations", e.outlier_deviations, 0, kInf,
      "Edge voxels farther from their neighbours than the mean plus so many deviations are "
      "removed");
  add("direction_radius", e.direction_radius, 0, 100,
      "Of the edge voxels that make an edge's covariance, eq. (6), m");
  auto& m = o.match;
  add("voxel_spacing", m.voxel_spacing, 0, 1000,
      "Match by one voxel in each cube of the octree at least this wide, m; 0: by all");
  add("edge_spacing", m.edge_spacing, 0, 1000,
      "Look for one edge voxel in each cube at least this wide, m; 0: everywhere, which a match "
      "without a search needs");
  add("search_translation", m.search.translation, 0, 1000,
      "Half width of the search around the guess in x and y, m; 0: start at the guess alone");
  add("search_height", m.search.height, 0, 1000, "Half width of the search in z, m");
  add("search_yaw_deg", m.search.yaw, 0, 180, "Half width of the search in yaw, deg", deg);
  add("search_cell", m.search.cell, 1e-3, 1000, "Coarse cell of the search, at least 2 voxels, m");
  add("search_hypotheses", m.search.hypotheses, 0, 1000,
      "Starts that the search hands on, beside the guess", count);
  add("k1", m.weights.k1, 0, kInf, "Factor of the occupancy weight, eq. (19)");
  add("k2", m.weights.k2, 0, kInf, "Factor of the direction weight, eq. (20)");
  add("edge_gate", m.edge_level.gate, 0, kInf, "Gate of edge pairs, m (Table I: 2)");
  add("edge_final_gate", m.edge_level.final_gate, 0, kInf,
      "The gate of edge pairs shrinks to this, by a fifth when an iteration moves less than a "
      "twentieth of it, m");
  add("edge_iterations", m.edge_level.max_iterations, 0, kInf,
      "Most iterations at the edge level; 0: skip the level", count);
  add("voxel_gate", m.voxel_level.gate, 0, kInf, "Gate of voxel pairs, m (Table I: 0.5)");
  add("voxel_final_gate", m.voxel_level.final_gate, 0, kInf,
      "The gate of voxel pairs shrinks to this in the same way, m (least: 2 voxels)");
  add("flatness", m.flatness, 1e-6, 1,
      "Of a piece of surface: variance across over variance along it (voxel_metric = surface)");
  add("voxel_iterations", m.voxel_level.max_iterations, 0, kInf,
      "Most iterations at the voxel level", count);
  add("solver_steps", m.solver.max_steps, 1, kInf, "Levenberg-Marquardt steps for one set of pairs",
      count);
  add("evaluation_voxels", m.evaluation_voxels, 0, kInf,
      "Voxels of each map, spread evenly, that the verdict asks; 0: all", count);
  add("min_step_translation", m.min_step_translation, 0, kInf,
      "A level has converged when an iteration moves the pose by less, m");
  add("min_step_rotation_deg", m.min_step_rotation, 0, 180, "and by less, deg", deg);
  auto& v = o.evaluation;
  add("inlier_mahalanobis", v.inlier_mahalanobis, 0, kInf,
      "Pairs below this Mahalanobis distance are inliers");
  add("max_free_conflict", v.max_free_conflict, 0, 1,
      "Largest share of obstacles that lie in the other map's free space; 1: not tested");
  add("min_overlap", v.min_overlap, 0, 1, "Least overlap, eq. (25), to judge by");
  add("min_probability", v.min_probability, 0, 1,
      "Least probability of being right, of the four measures above; 0: not tested");
  add("sure_probability", v.sure_probability, 0, 1,
      "A match from a guess that is accepted with less is compared with all other poses; 0: never");
  add("max_runner_up", v.max_runner_up, 0, 1,
      "Largest agreement of the second best pose over that of the best; 1: not tested");
  add("kl_threshold", o.merge.kl_threshold, 0, kInf,
      "Relative entropy up to which probabilities are averaged, nats (Table I: 0.1)");
  return list;
}

/** Names of the values of an enumerated parameter. */
template <class E>
using Names = std::vector<std::pair<E, const char*>>;
const Names<VoxelCovariance> kCovarianceNames = {{VoxelCovariance::Plain, "plain"},
                                                 {VoxelCovariance::Quantisation, "quantisation"}};
const Names<VoxelMetric> kMetricNames = {{VoxelMetric::Point, "point"},
                                         {VoxelMetric::Surface, "surface"}};
const Names<SearchRotations> kRotationNames = {{SearchRotations::Yaw, "yaw"},
                                               {SearchRotations::All, "all"}};
constexpr const char* kRotationsKey = "search_rotations";
constexpr const char* kMetricKey = "voxel_metric";
constexpr const char* kCovarianceKey = "voxel_covariance";
constexpr const char* kPolicyKey = "merge_policy";

template <class E>
std::string listOf(const Names<E>& names) {
  std::string list;
  for (const auto& n : names) list += (list.empty() ? "" : ", ") + std::string(n.second);
  return list;
}

template <class E>
const char* nameOf(E value, const Names<E>& names) {
  return std::find_if(names.begin(), names.end(), [&](const auto& n) { return n.first == value; })
      ->second;
}

template <class E>
void loadEnum(const mrpt::config::CConfigFileBase& source, const std::string& section,
              const char* key, const Names<E>& names, E& value) {
  const std::string text = source.read_string(section, key, nameOf(value, names));
  const auto found =
      std::find_if(names.begin(), names.end(), [&](const auto& n) { return text == n.second; });
  ASSERTMSG_(found != names.end(),
             "[" + section + "] " + key + " = " + text + " is none of " + listOf(names));
  value = found->first;
}

}  // namespace

void Options::loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                                 const std::string& section) {
  Options loaded(*this);
  const auto entries = entriesOf(loaded);

  std::vector<std::string> keys = {kRotationsKey, kMetricKey, kCovarianceKey, kPolicyKey};
  for (const Entry& e : entries) keys.emplace_back(e.key);
  mrpt::fusion::checkKeys(source, section, keys);

  for (const Entry& e : entries) {
    if (!source.keyExists(section, e.key)) continue;
    const double value =
        mrpt::fusion::readNumber(source, section, e.key, 0, e.min, e.max,
                                 e.unit == Entry::Unit::Count ? mrpt::fusion::NumberKind::Whole
                                                              : mrpt::fusion::NumberKind::Real);
    e.set(e.unit == Entry::Unit::Degrees ? value * M_PI / 180 : value);
  }
  loadEnum(source, section, kRotationsKey, kRotationNames, loaded.match.search.rotations);
  loadEnum(source, section, kMetricKey, kMetricNames, loaded.match.voxel_metric);
  loadEnum(source, section, kCovarianceKey, kCovarianceNames, loaded.match.voxel_covariance);
  loadEnum(source, section, kPolicyKey, mergePolicyNames(), loaded.merge.policy);
  *this = loaded;
}

void Options::saveToConfigFile(mrpt::config::CConfigFileBase& target,
                               const std::string& section) const {
  Options copy(*this);
  for (const Entry& e : entriesOf(copy)) {
    // To the six digits that people write: 80 deg is not 79.99999999999999.
    const double value = e.unit == Entry::Unit::Degrees ? e.get() * 180 / M_PI : e.get();
    target.write(section, e.key, mrpt::format("%g", value), -1, -1, e.comment);
  }
  target.write(section, kRotationsKey, nameOf(match.search.rotations, kRotationNames), -1, -1,
               "Without a guess: yaw (up is up in both maps), all (they have no common vertical)");
  target.write(section, kMetricKey, nameOf(match.voxel_metric, kMetricNames), -1, -1,
               "Voxel level: point (eq. 22, as published), surface (along normals)");
  target.write(section, kCovarianceKey, nameOf(match.voxel_covariance, kCovarianceNames), -1, -1,
               "Unit of the voxel covariance, eq. (4): plain (m^2, as published), quantisation");
  target.write(section, kPolicyKey, nameOf(merge.policy, mergePolicyNames()), -1, -1,
               "Of voxels that both maps know: " + listOf(mergePolicyNames()));
}
