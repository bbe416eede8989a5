// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/maps/config_check.h>
#include <mrpt/maps/map_files.h>
#include <mrpt/poses/CPosePDFGaussian.h>
#include <mrpt/slam/CProbabilisticMapMatching.h>
#include <mrpt/system/CTicTac.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

using namespace mrpt::slam;
using namespace mrpt::fusion;
using mrpt::maps::CEdgeVoxelMap;
using mrpt::maps::CMetricMap;
using mrpt::maps::CProbOctoMap;
using mrpt::poses::CPose3D;

// ---------------------------------------------------------------- options

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
std::vector<Entry> entriesOf(CProbabilisticMapMatching::TConfigParams& o) {
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

void CProbabilisticMapMatching::TConfigParams::loadFromConfigFile(
    const mrpt::config::CConfigFileBase& source, const std::string& section) {
  TConfigParams loaded(*this);
  const auto entries = entriesOf(loaded);

  std::vector<std::string> keys = {kRotationsKey, kMetricKey, kCovarianceKey, kPolicyKey};
  for (const Entry& e : entries) keys.emplace_back(e.key);
  mrpt::maps::checkKeys(source, section, keys);

  for (const Entry& e : entries) {
    if (!source.keyExists(section, e.key)) continue;
    const double value =
        mrpt::maps::readNumber(source, section, e.key, 0, e.min, e.max,
                               e.unit == Entry::Unit::Count ? mrpt::maps::NumberKind::Whole
                                                            : mrpt::maps::NumberKind::Real);
    e.set(e.unit == Entry::Unit::Degrees ? value * M_PI / 180 : value);
  }
  loadEnum(source, section, kRotationsKey, kRotationNames, loaded.match.search.rotations);
  loadEnum(source, section, kMetricKey, kMetricNames, loaded.match.voxel_metric);
  loadEnum(source, section, kCovarianceKey, kCovarianceNames, loaded.match.voxel_covariance);
  loadEnum(source, section, kPolicyKey, mergePolicyNames(), loaded.merge.policy);
  *this = loaded;
}

void CProbabilisticMapMatching::TConfigParams::saveToConfigFile(
    mrpt::config::CConfigFileBase& target, const std::string& section) const {
  TConfigParams copy(*this);
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

// ---------------------------------------------------------------- poses

Eigen::Isometry3d mrpt::fusion::toEigen(const CPose3D& pose) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = pose.getRotationMatrix().asEigen();
  T.translation() = Eigen::Vector3d(pose.x(), pose.y(), pose.z());
  return T;
}

CPose3D mrpt::fusion::toPose(const Eigen::Isometry3d& T) {
  return CPose3D(mrpt::math::CMatrixDouble44(Eigen::Matrix4d(T.matrix())));
}

Matrix6d mrpt::fusion::toYawPitchRollCovariance(const Matrix6d& covariance,
                                                const Eigen::Isometry3d& T) {
  // R = Rz(yaw) Ry(pitch) Rx(roll), so a small rotation is
  // w = dyaw e_z + dpitch Rz e_y + droll Rz Ry e_x, and t moves by rho + w x t.
  const CPose3D pose = toPose(T);
  const Eigen::Matrix3d Rz = Eigen::AngleAxisd(pose.yaw(), Eigen::Vector3d::UnitZ()).matrix();
  const Eigen::Matrix3d Ry = Eigen::AngleAxisd(pose.pitch(), Eigen::Vector3d::UnitY()).matrix();
  Eigen::Matrix3d w_of_angles;
  w_of_angles << Eigen::Vector3d::UnitZ(), Rz.col(1), (Rz * Ry).col(0);
  const Eigen::Vector3d t = T.translation();
  Eigen::Matrix3d minus_t_cross;
  minus_t_cross << 0, t.z(), -t.y(), -t.z(), 0, t.x(), t.y(), -t.x(), 0;
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>().setIdentity();
  J.topRightCorner<3, 3>() = minus_t_cross;
  J.bottomRightCorner<3, 3>() = w_of_angles.inverse();
  return J * covariance * J.transpose();
}

// ---------------------------------------------------------------- priors

namespace {
constexpr double kSigmas = 3;
constexpr double kEverywhere = 1000;  // m
}  // namespace

SearchParams mrpt::fusion::searchWithin(const mrpt::poses::CPose3DPDFGaussian& prior,
                                        const SearchParams& configured) {
  const auto& cov = prior.cov;
  ASSERTMSG_(cov.asEigen().allFinite() && cov.asEigen().diagonal().minCoeff() >= 0,
             "CProbabilisticMapMatching: the covariance of the initial guess is none");
  if (configured.translation <= 0 || cov.asEigen().isZero(0)) return configured;
  const double half_sum = 0.5 * (cov(0, 0) + cov(1, 1));
  const double largest =
      half_sum + std::hypot(0.5 * (cov(0, 0) - cov(1, 1)), 0.5 * (cov(0, 1) + cov(1, 0)));
  SearchParams search = configured;
  search.translation = kSigmas * std::sqrt(largest);
  if (search.translation >= kEverywhere) return everywhere(configured);
  search.translation = std::max(search.translation, configured.cell);
  search.height = kSigmas * std::sqrt(cov(2, 2));
  search.yaw = std::min(kSigmas * std::sqrt(cov(3, 3)), M_PI);
  return search;
}

mrpt::poses::CPose3DPDFGaussian mrpt::fusion::noGuess() {
  mrpt::poses::CPose3DPDFGaussian prior;
  prior.cov.setDiagonal(6, kEverywhere * kEverywhere);
  return prior;
}

// ---------------------------------------------------------------- steps

namespace {

std::shared_ptr<const CProbOctoMap> octomapOf(const CMetricMap& map) {
  auto octomap = mrpt::maps::asProbOctoMap(map);
  ASSERTMSG_(octomap, std::string("CProbabilisticMapMatching: a ") +
                          map.GetRuntimeClass()->className +
                          " is not, and holds no, 3-D occupancy map");
  return octomap;
}

/** A map to match, and the octrees that its features point to. */
class Matchable {
 public:
  explicit Matchable(const CMetricMap& map) {
    if (const auto* edges = dynamic_cast<const CEdgeVoxelMap*>(&map)) {
      edges_ = *edges;
      edge_tree_.emplace(edges->asOcTree());
    } else {
      map_ = octomapOf(map);
    }
  }

  bool isEdges() const { return !map_; }
  const octomap::OcTree& octree() const { return map_ ? map_->octree() : *edge_tree_; }

  MapFeatures edgeFeatures(const MatchParams& params) {
    if (!edge_tree_) {
      edges_ = CEdgeVoxelMap(*map_, params.edges);
      edge_tree_.emplace(edges_.asOcTree());
    }
    return featuresOfEdges(octree(), *edge_tree_, edges_.edges());
  }

 private:
  std::shared_ptr<const CProbOctoMap> map_;
  CEdgeVoxelMap edges_;
  std::optional<octomap::OcTree> edge_tree_;
};

double secondsSince(mrpt::system::CTicTac& clock) {
  const double s = clock.Tac();
  clock.Tic();
  return s;
}

}  // namespace

CProbabilisticMapMatching::CProbabilisticMapMatching() {
  setLoggerName("CProbabilisticMapMatching");
}

EdgeVoxels CProbabilisticMapMatching::edges(const CMetricMap& map) const {
  const mrpt::system::CTimeLoggerEntry timing(profiler, "edges");
  return extractEdges(extractOccupiedVoxels(octomapOf(map)->octree()), options.match.edges);
}

mrpt::poses::CPose3DPDF::Ptr CProbabilisticMapMatching::Align3DPDF(
    const CMetricMap* m1, const CMetricMap* m2,
    const mrpt::poses::CPose3DPDFGaussian& initialEstimationPDF,
    mrpt::optional_ref<TMetricMapAlignmentResult> outInfo) {
  ASSERTMSG_(m1 && m2, "CProbabilisticMapMatching: a map is null");
  ASSERTMSG_(toEigen(initialEstimationPDF.mean).matrix().allFinite(),
             "CProbabilisticMapMatching: the initial guess is not a pose");
  mrpt::system::CTicTac clock, total;
  TReturnInfo info;
  profiler.enter("features");
  Matchable a(*m1), b(*m2);
  info.by_edges = a.isEdges() || b.isEdges();
  const auto [fa, fb] =
      info.by_edges ? std::pair(a.edgeFeatures(options.match), b.edgeFeatures(options.match))
                    : computeFeatures(a.octree(), b.octree(), options.match);
  profiler.leave("features");
  ASSERTMSG_(fa.voxels.size() > 0, "CProbabilisticMapMatching: map m1 has no occupied voxel");
  ASSERTMSG_(fb.voxels.size() > 0, "CProbabilisticMapMatching: map m2 has no occupied voxel");
  info.voxels_m1 = fa.voxels.size();
  info.voxels_m2 = fb.voxels.size();
  info.edges_m1 = fa.edges.size();
  info.edges_m2 = fb.edges.size();
  info.seconds_features = secondsSince(clock);

  profiler.enter("match");
  MatchParams match_params = options.match;
  match_params.search = searchWithin(initialEstimationPDF, options.match.search);
  info.match = matchMaps(fa, fb, toEigen(initialEstimationPDF.mean), match_params, onIteration);
  profiler.leave("match");
  info.nIterations = static_cast<unsigned>(info.match.iterations.size());
  info.seconds_matching = secondsSince(clock);

  profiler.enter("evaluate");
  info.evaluation = judgeMatch(fa, fb, match_params, options.evaluation, info.match);
  if (info.by_edges) {
    info.evaluation.accepted = false;
    info.evaluation.reasons.emplace_back(
        "edges alone tell where the maps meet, not that they may be merged");
  }
  profiler.leave("evaluate");
  info.seconds_evaluation = secondsSince(clock);
  info.executionTime = total.Tac();
  MRPT_LOG_DEBUG_FMT("%u iterations, %zu pairs, %s", info.nIterations, info.match.pairs.size(),
                     info.evaluation.accepted ? "accepted" : "rejected");

  const auto gaussian = [](const Eigen::Isometry3d& T, const Matrix6d& covariance) {
    return mrpt::poses::CPose3DPDFGaussian(
        toPose(T), mrpt::math::CMatrixDouble66(toYawPitchRollCovariance(covariance, T)));
  };
  const auto pdf = std::make_shared<mrpt::poses::CPose3DPDFGaussian>(
      gaussian(info.match.T_a_b, info.match.covariance));
  std::vector<RankedPose> possible = info.match.hypotheses;  // no weight can be zero
  while (!possible.empty() && possible.back().agreement <= 0) possible.pop_back();
  info.hypotheses.resize(possible.size());
  std::transform(possible.begin(), possible.end(), info.hypotheses.begin(), [&](const auto& h) {
    mrpt::poses::CPose3DPDFSOG::TGaussianMode mode;
    mode.val = gaussian(h.T_a_b, h.covariance);
    mode.log_w = std::log(h.agreement);
    return mode;
  });
  if (outInfo) {
    TMetricMapAlignmentResult& wanted = outInfo.value().get();
    wanted.executionTime = info.executionTime;
    if (auto* all = dynamic_cast<TReturnInfo*>(&wanted)) *all = std::move(info);
  }
  return pdf;
}

mrpt::poses::CPosePDF::Ptr CProbabilisticMapMatching::AlignPDF(
    const CMetricMap* m1, const CMetricMap* m2,
    const mrpt::poses::CPosePDFGaussian& initialEstimationPDF,
    mrpt::optional_ref<TMetricMapAlignmentResult> outInfo) {
  mrpt::poses::CPose3DPDFGaussian prior(initialEstimationPDF);
  if (!prior.cov.asEigen().isZero(0))  // a pose in the plane says nothing of the height
    prior.cov(2, 2) = std::pow(options.match.search.height / kSigmas, 2);
  const auto pdf = Align3DPDF(m1, m2, prior, outInfo);
  auto plane = std::make_shared<mrpt::poses::CPosePDFGaussian>();
  plane->copyFrom(*pdf);
  return plane;
}

CProbabilisticMapMatching::TReturnInfo CProbabilisticMapMatching::evaluate(
    const CMetricMap& m1, const CMetricMap& m2, const CPose3D& pose) const {
  const auto a = octomapOf(m1), b = octomapOf(m2);
  const mrpt::system::CTimeLoggerEntry timing(profiler, "evaluate");
  mrpt::system::CTicTac clock;
  const auto [fa, fb] = computeFeatures(a->octree(), b->octree(), options.match);
  TReturnInfo info;
  info.voxels_m1 = fa.voxels.size();
  info.voxels_m2 = fb.voxels.size();
  info.match.T_a_b = toEigen(pose);
  info.match.pairs = pairVoxels(fa.voxels, fb.voxels, info.match.T_a_b, options.match);
  info.evaluation = judgeMatch(fa, fb, options.match, options.evaluation, info.match);
  info.executionTime = info.seconds_evaluation = clock.Tac();
  return info;
}

CProbOctoMap CProbabilisticMapMatching::merge(const CMetricMap& m1, const CMetricMap& m2,
                                              const CPose3D& pose) const {
  const mrpt::system::CTimeLoggerEntry timing(profiler, "merge");
  return CProbOctoMap(
      mergeMaps(octomapOf(m1)->octree(), octomapOf(m2)->octree(), toEigen(pose), options.merge));
}
