// SPDX-License-Identifier: BSD-3-Clause
#include "pmm_methods.h"

#include <mrpt/config/CConfigFile.h>
#include <tbb/parallel_invoke.h>

#include "support/matching_tools.h"

namespace mrpt::fusion::benchmark {
namespace {

class Matching : public Method {
 public:
  explicit Matching(const Settings& settings) : settings_(settings) {}

  void prepare(const MapPair& pair) override {
    tbb::parallel_invoke([&] { a_ = test::featuresOf(*pair.a, settings_); },
                         [&] { b_ = test::featuresOf(*pair.b, settings_); });
  }

  Registration align(const Eigen::Isometry3d& start) override {
    MatchResult result = matchMaps(a_, b_, start, settings_);
    const Evaluation evaluation = test::judgeMatch(a_, b_, settings_, settings_.evaluation, result);
    return {result.T_a_b,         static_cast<unsigned>(result.iterations.size()),
            evaluation.accepted,  evaluation.probability,
            evaluation.overlap,   evaluation.free_space.conflictRatio(),
            evaluation.runner_up, evaluation.inlier_ratio,
            result.covariance};
  }

 private:
  Settings settings_;
  MapFeatures a_, b_;
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
