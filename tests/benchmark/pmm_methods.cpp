// SPDX-License-Identifier: BSD-3-Clause
#include "pmm_methods.h"

#include <mrpt/config/CConfigFile.h>
#include <mrpt/fusion/alignment.h>
#include <tbb/parallel_invoke.h>

namespace mrpt::fusion::benchmark {
namespace {

class Matching : public Method {
 public:
  explicit Matching(const Settings& settings) : settings_(settings) {}

  void prepare(const MapPair& pair) override {
    tbb::parallel_invoke([&] { a_.emplace(pair.a, settings_.features); },
                         [&] { b_.emplace(pair.b, settings_.features); });
  }

  Registration align(const Eigen::Isometry3d& start) override {
    const Alignment found = mrpt::fusion::align(*a_, *b_, Prior::near(toPose(start)), settings_);
    const Evaluation& evaluation = found.evaluation;
    Registration r;
    r.T_a_b = found.match.T_a_b;
    r.iterations = static_cast<unsigned>(found.match.iterations.size());
    r.accepted = evaluation.accepted;
    r.probability = evaluation.probability;
    r.overlap = evaluation.overlap;
    r.conflict_ratio = evaluation.free_space.conflictRatio();
    r.runner_up = evaluation.runner_up;
    r.inlier_ratio = evaluation.inlier_ratio;
    r.rival_support = evaluation.rival_support;
    r.rival_same_side = evaluation.rival_same_side;
    r.missed_ratio = evaluation.free_space.missedRatio();
    r.without_free = evaluation.without_free_space;
    r.scale = found.scale;
    r.size_ratio = found.match.size_ratio.value;
    r.covariance = found.match.covariance;
    return r;
  }

 private:
  Settings settings_;
  std::optional<PreparedMap> a_, b_;
};

}  // namespace

std::unique_ptr<Method> makeMatching(const Settings& settings) {
  return std::make_unique<Matching>(settings);
}

Settings publishedSettings() {
  Settings settings;
  settings.loadFromConfigFile(mrpt::config::CConfigFile(CONFIG_DIR "/pmm_paper.ini"),
                              "ProbabilisticMapMatching");
  return settings;
}

Settings withoutSearch() {
  Settings settings;
  settings.search.translation = settings.features.edge_spacing = 0;
  return settings;
}

Settings firstLevelSettings() {
  Settings settings = publishedSettings();
  settings.registration.voxel_level.max_iterations = 0;
  return settings;
}

Settings withoutGuess() {
  Settings settings;
  settings.search = everywhere(settings.search);
  return settings;
}

std::unique_ptr<Method> makeMethod(const std::string& name) {
  if (name == "default") return makeMatching({});
  if (name == "anywhere") return makeMatching(withoutGuess());
  if (name == "no_search") return makeMatching(withoutSearch());
  if (name == "pmm_paper") return makeMatching(publishedSettings());
  if (name == "first_level") return makeMatching(firstLevelSettings());
  return makePclMethod(name);
}

}  // namespace mrpt::fusion::benchmark
