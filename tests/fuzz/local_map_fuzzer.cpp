// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Serialized CObservationLocalMap. After a first byte of 0 the input is the local map; else it is
 * the compressed part of a local map, in plain form. */

#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/obs/CObservationLocalMap.h>

#include <sstream>

#include "fuzz/fuzz_blobs.h"
#include "fuzz/fuzz_target.h"
#include "fuzz/fuzz_trees.h"

using namespace mrpt::fusion;
using mrpt::maps::CProbOctoMap;
using mrpt::obs::CObservationLocalMap;

namespace {

CObservationLocalMap localMap(const mrpt::maps::CMetricMap::Ptr& map) {
  CObservationLocalMap observation;
  observation.sensorLabel = "robot";
  observation.sequence = 3;
  observation.pose.mean = mrpt::poses::CPose3D(1, 2, 0.5, 0.3, 0, 0);
  observation.map = map;
  observation.smallest = true;  // the compressed part is xz data
  return observation;
}

const fuzz::Blob& blob() {
  static const fuzz::Blob blob(
      localMap(std::make_shared<CProbOctoMap>(std::move(fuzz::smallTrees().back()))));
  return blob;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::Input input(data, size);
  const bool raw = input.take<uint8_t>() == 0;
  const std::string bytes = raw ? std::string(input.rest()) : blob().replacedBy(input.rest());
  CObservationLocalMap observation;
  if (!fuzz::accepts([&] { map_tests::deserializeInto(bytes, observation); })) return 0;
  std::ostringstream text;
  observation.getDescriptionAsText(text);
  observation.exportTxtDataRow();
  map_tests::serialized(observation);
  return 0;
}

std::vector<std::string> fuzzSeeds() {
  std::vector<std::string> seeds = {
      '\0' + map_tests::serialized(localMap(nullptr)),
      '\0' + map_tests::serialized(localMap(std::make_shared<mrpt::maps::CEdgeVoxelMap>())),
      '\1' + blob().plain()};
  for (auto& tree : fuzz::smallTrees())
    seeds.push_back(
        '\0' + map_tests::serialized(localMap(std::make_shared<CProbOctoMap>(std::move(tree)))));
  return seeds;
}
