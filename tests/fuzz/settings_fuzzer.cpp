// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Settings in .ini files: the options of a match, and the definition of a CProbOctoMap. */

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/fusion/options.h>
#include <mrpt/maps/CProbOctoMap.h>

#include "fuzz/fuzz_target.h"

using namespace mrpt::fusion;
using mrpt::config::CConfigFileMemory;
using mrpt::maps::CProbOctoMap;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  CConfigFileMemory file;
  if (!fuzz::accepts([&] { file.setContent(std::string(fuzz::asText(data, size))); })) return 0;

  Options options;
  if (fuzz::accepts([&] { options.loadFromConfigFile(file, "match"); })) {
    CConfigFileMemory saved;
    options.saveToConfigFile(saved, "match");
    Options again;
    again.loadFromConfigFile(saved, "match");
    CConfigFileMemory saved_again;
    again.saveToConfigFile(saved_again, "match");
    fuzz::require(saved.getContent() == saved_again.getContent(),
                  "options are the same after they were saved and loaded");
  }
  fuzz::accepts([&] {
    CProbOctoMap::TMapDefinition definition;
    definition.loadFromConfigFile(file, "map");
    const std::shared_ptr<mrpt::maps::CMetricMap> map(
        CProbOctoMap::CreateFromMapDefinition(definition));
    map->isEmpty();
  });
  return 0;
}

std::vector<std::string> fuzzSeeds() {
  CConfigFileMemory options, none;
  Options().saveToConfigFile(options, "match");
  const std::string map =
      "[map_creationOpts]\nresolution = 0.07\n"
      "[map_insertOpts]\nmaxrange = 12.5\npruning = false\noccupancyThres = 0.6\nprobHit = 0.8\n"
      "probMiss = 0.3\nclampingThresMin = 0.06\nclampingThresMax = 0.95\n"
      "[map_likelihoodOpts]\ndecimation = 4\n";
  return {options.getContent(), map,
          "[match]\nmerge_policy = average // a comment\nsearch_yaw_deg = 1e1\n"};
}
