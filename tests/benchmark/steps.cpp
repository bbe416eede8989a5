// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * How long each step takes, by itself and on one thread, on pairs of maps of any size. Beside the
 * times stand `voxels`, the occupied voxels that the step goes through, `ns_per_voxel` of CPU, and
 * `bytes`: what the step has to read and write once even if it did nothing else. At the bandwidth
 * of `copy` they give a time that no such step can beat.
 */
#include <benchmark/benchmark.h>
#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/merging.h>
#include <stdlib.h>
#include <tbb/global_control.h>

#include <cstring>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "fusion_base/files.h"
#include "fusion_core/features/edges.h"
#include "fusion_core/features/surfaces.h"
#include "fusion_core/features/thinning.h"
#include "fusion_core/map/free_space.h"
#include "fusion_core/map/voxel_blocks.h"
#include "fusion_core/registration/residuals.h"
#include "fusion_core/search/pose_search.h"
#include "fusion_core/verdict/evaluation.h"
#include "fusion_octree/files.h"
#include "fusion_octree/insertion/scan_insertion.h"
#include "map_pair.h"
#include "support/matching_tools.h"

namespace {

namespace fs = std::filesystem;
using namespace mrpt::fusion;
using ::benchmark::State;
using mrpt::fusion::benchmark::errorOf;
using mrpt::fusion::benchmark::loadMapPair;
using mrpt::fusion::benchmark::MapPair;
using mrpt::fusion::benchmark::nearStart;

constexpr double kWideGate = 0.5, kNarrowGate = 0.2;  // with which the voxel level begins and ends

/** What the steps work on: each gets what the steps before it make. */
struct Workload {
  explicit Workload(const std::string& folder) : pair(loadMapPair(folder)) {}

  MapPair pair;
  Options params;
  MapFeatures a = test::featuresOf(*pair.a, params);
  MapFeatures b = test::featuresOf(*pair.b, params);
  DescriptorWeights weights = descriptorWeights(
      meanSquaredError(VoxelAssociation(a.matched.voxels)
                           .associate(b.matched.voxels, pair.T_a_b, {}, kWideGate)),
      occupancyUncertainty(a.voxels.probability, b.voxels.probability), 0,
      params.registration.weights);
  Eigen::Isometry3d guess = poseOf(nearStart(), pair);

  size_t voxelsOfBoth() const { return a.voxels.size() + b.voxels.size(); }
};

/** Of each pair once: steps on small and on large maps take turns, so that a machine's slower
 * minutes meet all of them. */
const Workload& workloadOf(const std::string& folder) {
  static std::map<std::string, const Workload> known;
  return known.try_emplace(folder, folder).first->second;
}

template <class T>
size_t bytesOf(const std::vector<T>& v) {
  return v.size() * sizeof(T);
}
size_t bytesOf(const octomap::OcTree& tree) { return tree.memoryUsage(); }
size_t bytesOf(const OccupiedVoxels& v) {
  return bytesOf(v.centre) + bytesOf(v.probability) + bytesOf(v.key);
}
/** A key and a mask for each block, a key and a depth for each larger cube. */
size_t bytesOf(const FreeSpace& free) {
  size_t bytes = 0;
  free.forEachCube(2, [&](const mrpt::fusion::OcTreeCube& cube) {
    bytes += sizeof(cube.key) + (cube.depth == FreeSpace::kBlock ? sizeof(uint64_t) : 1);
  });
  return bytes;
}
size_t bytesOf(const Surfaces& s) {
  return bytesOf(s.normal) + bytesOf(s.point) + bytesOf(s.variation) + bytesOf(s.weight);
}
size_t bytesOf(const EdgeVoxels& e) {
  return bytesOf(e.centre) + bytesOf(e.probability) + bytesOf(e.covariance);
}

/** Times \a step; what it returns is freed off the clock. \return The last one. */
template <class Step>
auto measure(State& state, Step&& step) {
  std::optional<decltype(step())> result;
  for (auto _ : state) {
    state.PauseTiming();
    result.reset();
    state.ResumeTiming();
    result.emplace(step());
    ::benchmark::ClobberMemory();
  }
  return std::move(*result);
}

void report(State& state, size_t voxels, size_t bytes) {
  using ::benchmark::Counter;
  state.counters["voxels"] = static_cast<double>(voxels);
  state.counters["bytes"] = static_cast<double>(bytes);
  state.counters["ns_per_voxel"] =  // an inverse rate is in seconds
      Counter(1e-9 * static_cast<double>(voxels),
              Counter::kIsIterationInvariantRate | Counter::kInvert);
}

/** A folder that is there as long as the object. */
class TemporaryFolder {
 public:
  TemporaryFolder() {
    if (!mkdtemp(path_.data())) throw std::runtime_error(path_ + ": cannot be made");
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_ = fs::temp_directory_path() / "step-benchmark.XXXXXX";
};

// The steps. -------------------------------------------------------------------------------------

void parse(State& state, const Workload& w) {
  const std::string file = mrpt::fusion::readFileBytes(w.pair.folder + "/map_a.ot");
  measure(state, [&] { return mrpt::fusion::parseOcTreeFile(file); });
  report(state, w.a.voxels.size(), file.size() + bytesOf(*w.pair.a));  // file in, tree out
}

void load(State& state, const Workload& w) {
  const std::string path = w.pair.folder + "/map_a.ot";
  measure(state, [&] { return mrpt::fusion::parseOcTreeFile(mrpt::fusion::readFileBytes(path)); });
  report(state, w.a.voxels.size(), fs::file_size(path) + bytesOf(*w.pair.a));  // file in, tree out
}

void extract(State& state, const Workload& w) {
  const auto voxels = measure(state, [&] { return extractOccupiedVoxels(*w.pair.a); });
  report(state, voxels.size(), bytesOf(*w.pair.a) + bytesOf(voxels));  // tree in, voxels out
}

void surfaces(State& state, const Workload& w) {
  const OccupiedVoxels& matched = w.a.matched.voxels;
  const auto s = measure(
      state, [&] { return computeSurfaces(matched, w.a.occupied, w.params.features.edges); });
  report(state, w.a.voxels.size(),  // all keys and those of the matched ones in, surfaces out
         bytesOf(w.a.voxels.key) + bytesOf(matched.key) + bytesOf(s));
}

void edges(State& state, const Workload& w) {
  const SurfaceVoxels& matched = w.a.matched;
  const auto e = measure(state, [&] {
    return extractEdges(w.a.voxels, w.a.occupied, matched,
                        edgeCandidates(matched, w.params.features), w.params.features.edges);
  });
  report(
      state, w.a.voxels.size(),  // all keys, the matched voxels and surfaces in, edges out
      bytesOf(w.a.voxels.key) + bytesOf(matched.voxels) + bytesOf(matched.surfaces) + bytesOf(e));
}

/** Extraction, index, surfaces and edges as matching does them. */
void features(State& state, const Workload& w) {
  const auto f = measure(state, [&] { return test::featuresOf(*w.pair.a, w.params); });
  report(state, f.voxels.size(),  // tree in, voxels, surfaces and edges out
         bytesOf(*w.pair.a) + bytesOf(f.voxels) + bytesOf(f.matched.voxels) +
             bytesOf(f.matched.surfaces) + bytesOf(f.edges));
}

void index(State& state, const Workload& w) {
  const auto kept = measure(state, [&] {
    const VoxelBlocks occupied(w.a.voxels.key);
    return thinOut(w.a.voxels, w.params.features.voxel_spacing);
  });
  report(state, w.a.voxels.size(),  // keys in, an index and a bit of each out, and what was kept
         bytesOf(w.a.voxels.key) + w.a.voxels.size() * sizeof(uint32_t) + bytesOf(kept.index) +
             bytesOf(kept.weight));
}

void associate(State& state, const Workload& w, double gate) {
  // Anew each time: an association remembers its last answer.
  const Pairs pairs = measure(state, [&] {
    return VoxelAssociation(w.a.voxels).associate(w.b.voxels, w.pair.T_a_b, w.weights, gate);
  });
  report(state, w.b.voxels.size(),  // places and probabilities of both in, pairs out
         bytesOf(w.a.voxels.centre) + bytesOf(w.a.voxels.probability) + bytesOf(w.b.voxels.centre) +
             bytesOf(w.b.voxels.probability) + bytesOf(pairs));
}
void associateNear(State& state, const Workload& w) { associate(state, w, kNarrowGate); }
void associateFar(State& state, const Workload& w) { associate(state, w, kWideGate); }

void linearize(State& state, const Workload& w) {
  const SurfaceVoxels &a = w.a.matched, &b = w.b.matched;
  const Pairs pairs =
      VoxelAssociation(a.voxels).associate(b.voxels, w.pair.T_a_b, w.weights, kNarrowGate);
  const auto linearizeAll = [&] {
    return linearizeSurfaces(a, b, pairs, w.pair.T_a_b, w.params.registration.flatness);
  };
  measure(state, linearizeAll);
  constexpr size_t kVoxel = sizeof(float) + 2 * sizeof(Eigen::Vector3f);
  report(state, w.b.voxels.size(),  // pairs in, and of two voxels each probability, normal, point
         bytesOf(pairs) + pairs.size() * 2 * kVoxel);
}

void search(State& state, const Workload& w) {
  // As many as the product takes: their number does not grow with the map.
  const SurfaceVoxels& all = w.b.matched;
  SurfaceVoxels few;
  few.voxels.resolution = all.voxels.resolution;
  const size_t stride = all.voxels.size() / 1000 + 1;
  for (size_t i = 0; i < all.voxels.size(); i += stride) {
    few.voxels.centre.push_back(all.voxels.centre[i]);
    few.voxels.key.push_back(all.voxels.key[i]);
    few.surfaces.normal.push_back(all.surfaces.normal[i]);
  }
  measure(state,
          [&] { return searchAround(w.a, w.a.matched.surfaces, few, w.guess, w.params.search); });
  report(state, w.voxelsOfBoth(),  // what is free and occupied in A in
         bytesOf(w.a.free) + bytesOf(w.a.voxels.key) + bytesOf(few.voxels.centre));
}

void match(State& state, const Workload& w) {
  const MatchResult r = measure(state, [&] { return matchMaps(w.a, w.b, w.guess, w.params); });
  size_t bytes = bytesOf(r.pairs);  // out; in, of both: free space, voxels, surfaces, edges
  for (const MapFeatures* f : {&w.a, &w.b})
    bytes += bytesOf(f->free) + bytesOf(f->voxels) + bytesOf(f->matched.voxels) +
             bytesOf(f->matched.surfaces) + bytesOf(f->edges);
  report(state, w.voxelsOfBoth(), bytes);
  state.counters["error_m"] = errorOf(r.T_a_b, w.pair).centre;  // has it done its work?
}

void evaluate(State& state, const Workload& w) {
  const Pairs pairs = test::pairVoxels(w.a, w.b, w.pair.T_a_b, w.params);
  measure(state, [&] { return evaluateMatch(w.a, w.b, pairs, w.pair.T_a_b, {}); });
  report(state, w.voxelsOfBoth(),  // pairs, and of both free space, places and probabilities in
         bytesOf(pairs) + bytesOf(w.a.free) + bytesOf(w.b.free) + bytesOf(w.a.voxels.centre) +
             bytesOf(w.b.voxels.centre) + bytesOf(w.a.voxels.probability) +
             bytesOf(w.b.voxels.probability));
}

void merge(State& state, const Workload& w) {
  const auto fused =
      measure(state, [&] { return mergeMaps(*w.pair.a, *w.pair.b, w.pair.T_a_b, {}); });
  report(state, w.voxelsOfBoth(),  // two trees in, one out
         bytesOf(*w.pair.a) + bytesOf(*w.pair.b) + bytesOf(*fused));
}

/** A scan of map A from a place in it: beams to its occupied voxels up to 15 m away. */
struct Scan {
  octomap::point3d origin;
  std::vector<octomap::point3d> ends;
};
std::vector<Scan> scansOf(const Workload& w) {
  constexpr size_t kScans = 8;
  constexpr double kRange = 15;
  const auto& centres = w.a.voxels.centre;
  const auto toOctomap = [](const auto& p) {
    return octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()),
                            static_cast<float>(p.z()));
  };
  std::vector<Scan> scans(kScans);
  for (size_t i = 0; i < kScans; i++) {
    scans[i].origin = toOctomap(centres[i * centres.size() / kScans]);
    for (const auto& centre : centres)
      if ((toOctomap(centre) - scans[i].origin).norm() <= kRange)
        scans[i].ends.push_back(toOctomap(centre));
  }
  return scans;
}

/** Inserts scans into an empty octree. `voxels` are the ends of the beams. */
template <class Insert>
void insertScans(State& state, const Workload& w, Insert&& insert) {
  const std::vector<Scan> scans = scansOf(w);
  size_t ends = 0;
  for (const Scan& scan : scans) ends += scan.ends.size();
  const auto tree = measure(state, [&] {
    auto built = std::make_unique<octomap::OcTree>(w.pair.a->getResolution());
    for (const Scan& scan : scans) insert(*built, scan);
    return built;
  });
  report(state, ends, ends * sizeof(octomap::point3d) + bytesOf(*tree));  // ends in, tree out
}
void insert(State& state, const Workload& w) {
  insertScans(state, w, [](octomap::OcTree& tree, const Scan& scan) {
    insertScan(tree, scan.ends, scan.origin, -1, true, mrpt::fusion::InnerNodes::Pruned);
  });
}
void insertWithOctomap(State& state, const Workload& w) {
  insertScans(state, w, [](octomap::OcTree& tree, const Scan& scan) {
    octomap::Pointcloud cloud;
    for (const auto& end : scan.ends) cloud.push_back(end);
    tree.insertPointCloud(cloud, scan.origin, -1, true);
    tree.updateInnerOccupancy();
    tree.prune();
  });
}

void save(State& state, const Workload& w) {
  const TemporaryFolder folder;
  const std::string path = folder.file("map.ot");
  measure(state, [&] {
    mrpt::fusion::saveOcTree(*w.pair.a, path);
    return 0;
  });
  report(state, w.a.voxels.size(), bytesOf(*w.pair.a) + fs::file_size(path));  // tree in, file out
}

/** What the memory gives at best: both buffers are far larger than any cache. */
void copy(State& state) {
  constexpr size_t kSize = size_t{1} << 28U;
  const std::vector<char> from(kSize, 1);
  std::vector<char> to(kSize, 0);
  for (auto _ : state) {
    std::memcpy(to.data(), from.data(), kSize);
    ::benchmark::ClobberMemory();
  }
  state.counters["bytes"] = static_cast<double>(bytesOf(from) + bytesOf(to));
}

// ------------------------------------------------------------------------------------------------

using Step = void (*)(State&, const Workload&);
const std::vector<std::pair<const char*, Step>> kSteps = {
    {"parse", parse},
    {"load", load},
    {"extract", extract},
    {"surfaces", surfaces},
    {"edges", edges},
    {"features", features},
    {"index", index},
    {"associate_0.2m", associateNear},
    {"associate_0.5m", associateFar},
    {"linearize", linearize},
    {"search", search},
    {"match", match},
    {"evaluate", evaluate},
    {"merge", merge},
    {"insert", insert},
    {"insert_octomap", insertWithOctomap},
    {"save", save},
};

/** Settings that all benchmarks have. */
void configure(::benchmark::internal::Benchmark* b) {
  b->Unit(::benchmark::kMillisecond)->MeasureProcessCPUTime();
}

int run(int argc, char** argv) {
  ::benchmark::Initialize(&argc, argv);
  if (argc < 2 || argv[1][0] == '-') {
    std::cerr << "Usage: step-benchmark [--benchmark_...] PAIR...\n"
                 "Times each step on pairs of maps: folders with map_a.ot, map_b.ot, T_a_b.txt.\n";
    return 2;
  }
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  configure(::benchmark::RegisterBenchmark("copy", copy));
  for (int i = 1; i < argc; i++) {
    const std::string folder = argv[i];
    const std::string name = fs::path(folder + "/.").parent_path().filename();
    for (const auto& [step_name, step] : kSteps)
      configure(::benchmark::RegisterBenchmark(
          (std::string(step_name) + "/" + name).c_str(),
          [step = step, folder](State& state) { step(state, workloadOf(folder)); }));
  }
  ::benchmark::RunSpecifiedBenchmarks();
  ::benchmark::Shutdown();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    std::cerr << "step-benchmark: " << e.what() << "\n";
    return 1;
  }
}
