// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Packs and reads indices of maps. */
#include "fusion_link/map_index.h"

#include <cmath>
#include <stdexcept>
#include <vector>

#include "fusion_base/byte_reader.h"
#include "fusion_base/byte_writer.h"
#include "fusion_base/packing.h"
#include "fusion_octree/resolution.h"

namespace mrpt::fusion {
namespace {

/** Largest unpacked size: head, blocks, and 16 values of the trunk for each block. */
constexpr size_t kMostIndexBytes = 1024 + kMostBlocks * (16 + 16 * 12);

/** Numbers of 8 bytes by the planes of their bytes: most planes are zeros. */
void appendPlanes(const std::vector<uint64_t>& numbers, std::string& out) {
  for (unsigned i = 0; i < sizeof(uint64_t); i++)
    for (const uint64_t n : numbers) out.push_back(static_cast<char>(n >> (8 * i) & 0xFFU));
}

std::vector<uint64_t> takePlanes(ByteReader& in, size_t count) {
  std::vector<uint64_t> numbers(count);
  for (unsigned i = 0; i < sizeof(uint64_t); i++)
    for (uint64_t& n : numbers) n |= uint64_t{in.take<uint8_t>()} << (8 * i);
  return numbers;
}

size_t takeCount(ByteReader& in, size_t most) {
  const auto count = in.take<uint64_t>();
  if (count > most || count > in.size()) corrupt("the index of a map is corrupt: too many entries");
  return count;
}

float takeFinite(ByteReader& in) {
  const auto value = in.take<float>();
  if (!std::isfinite(value)) corrupt("the index of a map is corrupt: a value is not finite");
  return value;
}

void checkBlocks(const MapIndex& index) {
  for (const auto& [code, version] : index.blocks) {
    if (!cubeOf(code)) corrupt("the index of a map is corrupt: a block is no cube");
    if (version == 0 || version > index.version)
      corrupt("the index of a map is corrupt: a block has a version that the map has not");
    for (BlockCode above = code >> 3U; above; above >>= 3U)
      if (index.blocks.count(above) > 0)
        corrupt("the index of a map is corrupt: a block lies in another block");
  }
}

}  // namespace

uint64_t hashOf(const std::map<BlockCode, BlockBytes>& blocks) {
  uint64_t hash = 0xcbf29ce484222325ULL;  // FNV-1a
  const auto mix = [&](std::string_view bytes) {
    for (const char c : bytes) hash = (hash ^ static_cast<uint8_t>(c)) * 0x100000001b3ULL;
  };
  for (const auto& [code, bytes] : blocks) {
    std::string head;
    appendValue(code, head);
    appendValue(uint64_t{bytes->size()}, head);
    mix(head);
    mix(*bytes);
  }
  return hash;
}

std::string toBytes(const MapIndex& index) {
  std::string out;
  appendValue(index.version, out);
  appendValue(index.hash, out);
  appendValue(index.trunk.resolution, out);
  const auto& m = index.trunk.model;
  for (const float value : {m.clamp_min, m.clamp_max, m.hit, m.miss, m.occupancy_threshold})
    appendValue(value, out);
  appendValue(uint64_t{index.blocks.size()}, out);
  std::vector<uint64_t> steps, ages, codes;
  BlockCode last = 0;
  for (const auto& [code, version] : index.blocks) {
    steps.push_back(code - last);
    ages.push_back(index.version - version);
    last = code;
  }
  appendPlanes(steps, out);
  appendPlanes(ages, out);
  appendValue(uint64_t{index.trunk.values.size()}, out);
  for (const auto& value : index.trunk.values) codes.push_back(value.first);
  appendPlanes(codes, out);
  for (const auto& value : index.trunk.values) appendValue(value.second, out);
  return packed(out, Packing::Smallest);
}

MapIndex indexOf(std::string_view bytes) {
  const std::string plain = unpacked(bytes, [](std::string_view) { return kMostIndexBytes; });
  ByteReader in(plain);
  MapIndex index;
  index.version = in.take<uint64_t>();
  if (index.version == 0 || index.version > kMostVersion)
    corrupt("the index of a map is corrupt: its version is out of range");
  index.hash = in.take<uint64_t>();
  index.trunk.resolution = in.take<double>();
  checkResolution(index.trunk.resolution);
  auto& m = index.trunk.model;
  for (float* value : {&m.clamp_min, &m.clamp_max, &m.hit, &m.miss, &m.occupancy_threshold})
    *value = takeFinite(in);
  const size_t count = takeCount(in, kMostBlocks);
  const auto steps = takePlanes(in, count), ages = takePlanes(in, count);
  BlockCode code = 0;
  for (size_t i = 0; i < count; i++) {
    code += steps[i];
    index.blocks[code] = ages[i] < index.version ? index.version - ages[i] : 0;
  }
  if (index.blocks.size() != count)
    corrupt("the index of a map is corrupt: a block is there twice");
  checkBlocks(index);
  const size_t values = takeCount(in, 16 * kMostBlocks);
  for (const uint64_t above : takePlanes(in, values)) index.trunk.values.emplace_back(above, 0.F);
  for (auto& value : index.trunk.values) value.second = takeFinite(in);
  if (in.size() > 0) corrupt("the index of a map is corrupt: it does not end");
  return index;
}

}  // namespace mrpt::fusion
