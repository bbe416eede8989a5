// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Replays fuzz targets without a fuzzer:
 *   fuzz_replay TARGET [FILE|FOLDER]...   runs TARGET on its seeds and on the files
 *   fuzz_replay --seeds TARGET FOLDER     writes the seeds of TARGET to FOLDER */

#include <sys/resource.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "fuzz_targets.inc"  // by CMake: declares the functions of each target, and kTargets
#include "support/sanitizers.h"

namespace fs = std::filesystem;

namespace {

/** Lets allocations fail from 2 GB on, except in builds with a sanitizer. */
void limitMemory() {
  if (map_tests::kHasSanitizer) return;
  constexpr rlim_t kMost = rlim_t{2} << 30U;
  const rlimit limit{kMost, kMost};
  ::setrlimit(RLIMIT_AS, &limit);
}

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void run(const Target& target, const std::string& name, const std::string& input) {
  std::cout << name << " (" << input.size() << " bytes)" << std::endl;
  target.run(reinterpret_cast<const uint8_t*>(input.data()), input.size());
}

int replay(const std::string& name, const std::vector<std::string>& paths) {
  const Target& target = kTargets.at(name);
  const auto seeds = target.seeds();
  for (size_t i = 0; i < seeds.size(); i++) run(target, "seed " + std::to_string(i), seeds[i]);
  run(target, "nothing", "");
  for (const fs::path path : paths) {
    std::vector<fs::path> files;
    if (fs::is_directory(path))
      files.assign(fs::directory_iterator(path), {});
    else if (fs::exists(path))
      files.push_back(path);
    std::sort(files.begin(), files.end());
    for (const auto& file : files) run(target, file.filename().string(), read(file));
  }
  return 0;
}

int writeSeeds(const std::string& name, const fs::path& folder) {
  fs::create_directories(folder);
  const auto seeds = kTargets.at(name).seeds();
  for (size_t i = 0; i < seeds.size(); i++)
    std::ofstream(folder / ("seed" + std::to_string(i)), std::ios::binary) << seeds[i];
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  try {
    limitMemory();
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 2);
    if (arguments.size() == 3 && arguments[0] == "--seeds")
      return writeSeeds(arguments[1], arguments[2]);
    if (!arguments.empty() && kTargets.count(arguments[0]))
      return replay(arguments[0], {arguments.begin() + 1, arguments.end()});
    std::cerr << "usage: fuzz_replay [--seeds] TARGET [FILE|FOLDER]...\nTargets:";
    for (const auto& [name, target] : kTargets) std::cerr << " " << name;
    std::cerr << "\n";
    return 2;
  } catch (const std::exception& e) {
    std::cerr << "fuzz_replay: " << e.what() << "\n";
    return 1;
  }
}
