// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Octrees for fuzz targets. */

#include "fuzz_trees.h"

#include <lzma.h>

#include <cmath>

#include "fusion_octree/build.h"
#include "support/test_maps.h"

namespace mrpt::fusion::fuzz {

using test::Cell;
using test::MapWriter;

std::vector<std::unique_ptr<octomap::OcTree>> smallTrees() {
  std::vector<std::unique_ptr<octomap::OcTree>> trees;
  trees.push_back(std::make_unique<octomap::OcTree>(0.1));
  trees.push_back(MapWriter(0.05).voxel({3, -5, 7}, test::kOccupied).unpruned());
  trees.push_back(MapWriter(0.2).box({0, 0, 0}, {7, 7, 7}, test::kFree).pruned());
  trees.push_back(MapWriter(0.1)
                      .box({1, 1, 1}, {6, 5, 4}, test::kFree)
                      .shell({0, 0, 0}, {7, 6, 5}, test::kOccupied)
                      .pruned());
  auto lazy = MapWriter(0.1).box({-2, -2, -2}, {1, 1, 1}, 1.5F).unpruned();
  lazy->getRoot()->setLogOdds(0.25F);  // not the maximum of its children
  trees.push_back(std::move(lazy));
  return trees;
}

namespace {

constexpr int kMostBoxes = 8;

struct Box {
  int16_t low[3];
  uint8_t side[3];  // less one
  int8_t log_odds;  // in units of 1/32
  uint8_t kind;     // 0: filled, 1: shell, 2: a leaf of a power of two
};
constexpr uint8_t kKinds = 3;

Box takeBox(Input& input) {
  Box box{};
  for (auto& low : box.low) low = input.take<int16_t>();
  for (auto& side : box.side) side = input.take<uint8_t>();
  box.log_odds = input.take<int8_t>();
  box.kind = static_cast<uint8_t>(input.take<uint8_t>() % kKinds);
  return box;
}

void put(Output& output, const Box& box) {
  for (const auto low : box.low) output.put(low);
  for (const auto side : box.side) output.put(side);
  output.put(box.log_odds).put(box.kind);
}

}  // namespace

std::unique_ptr<octomap::OcTree> treeFrom(Input& input) {
  constexpr double kFinest = 1e-4, kCoarsest = 1e6;
  double resolution = std::abs(input.number());
  if (!(resolution >= kFinest && resolution <= kCoarsest)) resolution = 0.1;
  MapWriter map(resolution);
  const int boxes = input.take<uint8_t>() % (kMostBoxes + 1);
  for (int i = 0; i < boxes; i++) {
    const Box box = takeBox(input);
    const Cell low = {box.low[0], box.low[1], box.low[2]};
    Cell high{};
    for (size_t axis = 0; axis < 3; axis++) {
      // A filled box has up to 16 x 16 x 16 voxels, a shell up to 32 x 32 x 32.
      const int most = box.kind == 1 ? 32 : 16;
      high[axis] = std::min(low[axis] + box.side[axis] % most, 32767);
    }
    const float log_odds = static_cast<float>(box.log_odds) / 32;
    if (box.kind == 1)
      map.shell(low, high, log_odds);
    else
      map.box(low, high, log_odds);
  }
  return map.pruned();
}

void describeRoom(Output& output, double resolution) {
  const std::vector<Box> boxes = {
      {{1, 1, 1}, {15, 13, 5}, -64, 0}, {{0, 0, 0}, {17, 15, 7}, 112, 1},
      {{3, 2, 1}, {3, 2, 3}, 112, 1},   {{12, 9, 1}, {1, 5, 4}, 112, 1},
      {{9, 1, 1}, {4, 1, 5}, 112, 1},
  };
  output.number(resolution).put(static_cast<uint8_t>(boxes.size()));
  for (const Box& box : boxes) put(output, box);
}

std::string xzCompressed(std::string_view bytes) {
  lzma_options_lzma options;
  ::lzma_lzma_preset(&options, 0);
  options.dict_size = LZMA_DICT_SIZE_MIN;  // larger tables take longer to clear than the rest
  lzma_filter filters[] = {{LZMA_FILTER_LZMA2, &options}, {LZMA_VLI_UNKNOWN, nullptr}};
  std::string out(::lzma_stream_buffer_bound(bytes.size()), '\0');
  size_t size = 0;
  require(::lzma_stream_buffer_encode(
              filters, LZMA_CHECK_CRC32, nullptr, reinterpret_cast<const uint8_t*>(bytes.data()),
              bytes.size(), reinterpret_cast<uint8_t*>(out.data()), &size, out.size()) == LZMA_OK,
          "any bytes can be compressed");
  out.resize(size);
  return out;
}

std::string xzDecompressed(std::string_view bytes) {
  std::string out(size_t{1} << 24U, '\0');
  uint64_t memory = UINT64_MAX;
  size_t from = 0, size = 0;
  require(::lzma_stream_buffer_decode(
              &memory, 0, nullptr, reinterpret_cast<const uint8_t*>(bytes.data()), &from,
              bytes.size(), reinterpret_cast<uint8_t*>(out.data()), &size, out.size()) == LZMA_OK,
          "what was compressed can be decompressed");
  out.resize(size);
  return out;
}

}  // namespace mrpt::fusion::fuzz
