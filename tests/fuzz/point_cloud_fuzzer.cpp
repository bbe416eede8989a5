// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Point clouds, .pcd and .ply, and their maps. */

#include "fusion_octree/files.h"
#include "fusion_octree/point_clouds/cloud_map.h"
#include "fuzz/fuzz_target.h"
#include "support/cloud_files.h"

using namespace mrpt::fusion;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::unique_ptr<octomap::OcTree> map;
  if (!fuzz::accepts([&] { map = parseCloudMap(fuzz::asText(data, size), {}); })) return 0;
  const std::string written = toOtFile(*map);
  fuzz::require(toOtFile(*parseOcTreeFile(written)) == written,
                "the map of a cloud is the same after it was written and read");
  fuzz::accepts([&] {
    parseCloudMap(fuzz::asText(data, size), {0.5, octomap::point3d(0.1F, -0.2F, 0.3F)});
  });
  return 0;
}

std::vector<std::string> fuzzSeeds() {
  const map_tests::Points points = {{1, 2, 3}, {-0.5F, 0, 0.25F}, {0.05F, 0.1F, -7}};
  std::vector<std::string> seeds;
  for (const auto& file : map_tests::cloudFiles(points)) seeds.push_back(file.bytes);
  seeds.push_back(map_tests::pcdFile(points, "ascii", "1 2 0.5 1 0 0 0"));
  return seeds;
}
