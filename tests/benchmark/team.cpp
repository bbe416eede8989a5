// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Command line of the benchmark of teams: fuses the maps of one mission, without false matches and
 * with, beside two baselines. Prints a CSV line for each map. scripts/benchmark_team.py makes
 * missions and runs it.
 */
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <ctime>
#include <iostream>

#include "fusion_team/graph/team_fusion.h"
#include "map_pair.h"
#include "team_mission.h"

namespace {

using namespace mrpt::fusion;
using namespace mrpt::fusion::benchmark;
using Eigen::Isometry3d;

double cpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void printHeader(std::ostream& csv) {
  csv << "mission,edges,method,robot,is_stranger,placed,error_m,error_deg,nees,probability,"
         "place_error_m,place_error_deg,runner_up,conflict_ratio,overlap,confirmed,cpu_s\n";
}

/** Prints the error of a pose, "inf,inf" for a map that has no right pose. */
void printError(const std::optional<Isometry3d>& pose, const std::optional<Isometry3d>& truth,
                std::ostream& csv) {
  if (!pose || !truth) {
    csv << (pose ? "inf,inf," : ",,");
    return;
  }
  const Isometry3d off = truth->inverse() * *pose;
  csv << off.translation().norm() << ',' << Eigen::AngleAxisd(off.linear()).angle() * 180 / M_PI
      << ',';
}

/** One mission and the matches of its pairs. */
class Experiment {
 public:
  Experiment(const TeamMission& mission, std::string edges, double cpu_before, std::ostream& csv)
      : mission_(mission), edges_(std::move(edges)), cpu_before_(cpu_before), csv_(csv) {}

  void run(const std::vector<PairMatch>& matches, const Options& options, PairMemory& memory) {
    const double before = cpuSeconds();
    const PlacedTeam team = placeByMatches(mission_.maps, matches, options, memory);
    const double cpu = cpu_before_ + cpuSeconds() - before;
    for (size_t k = 0; k < mission_.maps.size(); k++) {
      const FusionMember& m = team.members[k];
      const Isometry3d pose = toEigen(m.pose.mean);
      begin("team", k, m.joined, pose);
      if (k > 0 && m.joined && mission_.truth(k))
        csv_ << neesOf(pose, fromYawPitchRollCovariance(m.pose.cov.asEigen(), pose),
                       *mission_.truth(k));
      const PlacedMap& place = team.places[k];
      csv_ << ',' << m.alignment.evaluation.probability << ',';
      printError(place.pose, mission_.truth(k), csv_);
      csv_ << place.runner_up << ',' << place.areas.conflictRatio() << ',' << place.overlap << ','
           << place.confirmed << ',' << cpu << '\n';
    }
    printPoses("growth", grownByMatches(mission_.maps.size(), matches, false));
    printPoses("tree", grownByMatches(mission_.maps.size(), matches, true));
  }

 private:
  void begin(const char* method, size_t k, bool is_placed, const std::optional<Isometry3d>& pose) {
    csv_ << mission_.name << ',' << edges_ << ',' << method << ',' << mission_.maps[k].robot << ','
         << !mission_.truth(k) << ',' << is_placed << ',';
    printError(pose, mission_.truth(k), csv_);
  }

  void printPoses(const char* method, const std::vector<std::optional<Isometry3d>>& poses) {
    for (size_t k = 0; k < poses.size(); k++) {
      begin(method, k, poses[k].has_value(), poses[k]);
      csv_ << ",,,,,,,,\n";
    }
  }

  const TeamMission& mission_;
  const std::string edges_;
  const double cpu_before_;
  std::ostream& csv_;
};

int run(int argc, char** argv) {
  CLI::App app{"Fuses the maps of a mission whose poses are known. Prints CSV."};
  std::string folder;
  FalseEdges edges;
  unsigned seed = 1, threads = 1;
  app.add_option("MISSION", folder, "Folder with robot_I.ot, T_robot_I_w.txt and stranger_I.ot")
      ->required();
  app.add_option("--false-edges", edges.share,
                 "Also with so many false matches that claim to be sure, share of the pairs")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--bay", edges.bay, "Shift of every second false match, m")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--seed", seed, "Seed of the false matches")->capture_default_str();
  app.add_option("--threads", threads, "Most threads")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);

  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  const Options options;
  const TeamMission mission = loadTeamMission(folder, options.features);
  PairMemory memory;
  ThreadExecutor executor;
  std::vector<PairMatch> matches = matchPairs(mission.maps, options, executor, {}, memory);
  const double cpu = cpuSeconds();
  printHeader(std::cout);
  Experiment(mission, "own", cpu, std::cout).run(matches, options, memory);
  if (edges.share > 0) {
    std::mt19937 generator(seed);
    addFalseEdges(mission, edges, generator, matches);
    Experiment(mission, "false", cpu, std::cout).run(matches, options, memory);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    std::cerr << "team-benchmark: " << e.what() << "\n";
    return 1;
  }
}
