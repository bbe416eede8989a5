// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Matching two small maps from any guess with any covariance: search, registration and verdict. */

#include <mrpt/fusion/alignment.h>

#include "fuzz/fuzz_target.h"
#include "fuzz/fuzz_trees.h"

using namespace mrpt::fusion;

namespace {

/** Settings under which a match of small maps takes milliseconds. */
Options cheapOptions() {
  Options options;
  options.search.translation = 1;
  options.search.height = 0.3;
  options.search.budget.small_work = 1e5;
  options.search.budget.max_work = 1e6;
  options.search.budget.max_cells = 1e5;
  options.search.budget.kept_places = 64;
  options.search.budget.min_hypotheses_everywhere = 8;
  options.registration.edge_level.max_iterations = 4;
  options.registration.voxel_level.max_iterations = 4;
  return options;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::Input input(data, size);
  mrpt::poses::CPose3DPDFGaussian prior;
  double at[6];
  for (double& number : at) number = input.number();
  prior.mean = mrpt::poses::CPose3D(at[0], at[1], at[2], at[3], at[4], at[5]);
  for (int i = 0; i < 6; i++) prior.cov(i, i) = input.number();
  prior.cov(0, 1) = prior.cov(1, 0) = input.number();
  const std::shared_ptr<const octomap::OcTree> a = fuzz::treeFrom(input), b = fuzz::treeFrom(input);
  static const Options options = cheapOptions();
  const auto isProbability = [](double p) { return p >= 0 && p <= 1; };
  fuzz::accepts([&] {
    const PreparedMap map_a(a, options.features), map_b(b, options.features);
    const Alignment at_guess = evaluate(map_a, map_b, prior.mean, options);
    fuzz::require(isProbability(at_guess.evaluation.probability), "a probability is in [0,1]");
    const Alignment found = align(map_a, map_b, Prior::gaussian(prior), options);
    fuzz::require(isProbability(found.evaluation.probability), "a probability is in [0,1]");
    found.pose();
    found.hypotheses();
  });
  return 0;
}

std::vector<std::string> fuzzSeeds() {
  std::vector<std::string> seeds;
  for (const double sigma2 : {0.0, 0.01, 1e6})
    for (const double resolution : {0.125, 0.1}) {
      fuzz::Output output;
      for (const double number : {0.25, -0.125, 0.0, 0.0625, 0.0, 0.0}) output.number(number);
      for (int i = 0; i < 7; i++) output.number(i < 6 ? sigma2 : 0);
      fuzz::describeRoom(output, 0.125);
      fuzz::describeRoom(output, resolution);
      seeds.push_back(output.bytes());
    }
  return seeds;
}
