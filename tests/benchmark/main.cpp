// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Command line of the benchmark: one experiment on one pair of maps, as CSV. scripts/benchmark.sh
 * runs them all.
 */
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

#include "experiments.h"
#include "kinds.h"

namespace {

namespace fs = std::filesystem;
using namespace mrpt::fusion::benchmark;

/** A CSV file that is there only when it is complete. */
class CsvFile {
 public:
  explicit CsvFile(fs::path path) : path_(std::move(path)), part_(path_.string() + ".part") {
    fs::create_directories(path_.parent_path());
    stream_.open(part_);
  }
  std::ostream& stream() { return stream_; }
  void finish() {
    stream_.close();
    if (!stream_) throw std::runtime_error(path_.string() + ": cannot be written");
    fs::rename(part_, path_);
  }

 private:
  fs::path path_, part_;
  std::ofstream stream_;
};

int run(int argc, char** argv) {
  CLI::App app{"One experiment of the benchmark on one pair of maps."};
  std::string experiment, folder, method, out;
  std::vector<std::string> others;
  Effort effort;
  unsigned threads = 1;
  const std::map<std::string, std::function<void(const MapPair&, std::ostream&)>> experiments = {
      {"data", describeData},
      {"edge_iterations",
       [&](const MapPair& pair, std::ostream& csv) { matchEdges(pair, effort, csv); }},
      {"overlap",
       [&](const MapPair& pair, std::ostream& csv) { reduceOverlap(pair, effort, csv); }},
      {"anywhere",
       [&](const MapPair& pair, std::ostream& csv) { alignFromAnywhere(pair, effort, csv); }},
      {"verdicts",
       [&](const MapPair& pair, std::ostream& csv) { judgeVerdicts(pair, effort, csv); }},
      {"kinds",
       [&](const MapPair& pair, std::ostream& csv) {
         std::vector<MapPair> of_others;
         for (const std::string& other : others) of_others.push_back(loadMapPair(other));
         judgeKinds(pair, of_others, effort, csv);
       }},
      {"mixes", [&](const MapPair& pair, std::ostream& csv) { mixMaps(pair, effort, csv); }},
      {"merging", mergeByPolicy},
      {"ablation", [&](const MapPair& pair, std::ostream& csv) { ablate(pair, effort, csv); }},
      {"speed", [&](const MapPair& pair, std::ostream& csv) { compareSpeed(pair, effort, csv); }},
  };
  std::set<std::string> names = {"starts"};
  for (const auto& [name, run] : experiments) names.insert(name);
  app.add_option("EXPERIMENT", experiment, "What to run")->required()->check(CLI::IsMember(names));
  app.add_option("PAIR", folder, "Folder with map_a.ot, map_b.ot, T_a_b.txt [and reference.ot]")
      ->required();
  app.add_option("--method", method, "For starts: which method");
  app.add_option("--other", others, "For kinds: folders of pairs of other places");
  app.add_option("--kind", effort.kind, "For kinds: the only kind of maps, as the table names it");
  app.add_option("--stride", effort.stride, "Take every so many-th start or cut")
      ->check(CLI::PositiveNumber);
  app.add_option("--rounds", effort.rounds, "For speed: how often to measure")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--threads", threads, "Most threads of our own methods; speed sets its own")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--out", out, "Folder: EXPERIMENT/PAIR[-METHOD].csv is written there")->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::Error& e) {
    return app.exit(e) ? 2 : 0;
  }

  std::optional<tbb::global_control> limit;  // the least of all limits holds
  if (experiment != "speed") limit.emplace(tbb::global_control::max_allowed_parallelism, threads);
  const MapPair pair = loadMapPair(folder);
  const auto fileFor = [&](const std::string& table) {
    return CsvFile(fs::path(out) / table /
                   (pair.name + (method.empty() ? "" : "-" + method) + ".csv"));
  };
  CsvFile csv = fileFor(experiment);
  if (experiment == "starts") {
    CsvFile inliers = fileFor("inliers"), costs = fileFor("methods");
    alignFromStarts(pair, method, effort, csv.stream(), inliers.stream(), costs.stream());
    inliers.finish();
    costs.finish();
  } else {
    experiments.at(experiment)(pair, csv.stream());
  }
  csv.finish();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    std::cerr << "fusion-benchmark: " << e.what() << "\n";
    return 1;
  }
}
