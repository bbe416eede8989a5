// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/voxel_index.h>

#include <algorithm>
#include <cmath>

namespace mrpt::fusion {

VoxelIndex::VoxelIndex(const std::vector<octomap::OcTreeKey>& keys) {
  std::vector<uint64_t> blocks(keys.size());
  std::transform(keys.begin(), keys.end(), blocks.begin(),
                 [](const auto& k) { return blockKey(k[0] >> 3, k[1] >> 3, k[2] >> 3); });
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());

  size_t capacity = 16;
  while (capacity < 2 * blocks.size()) capacity *= 2;
  mask_ = capacity - 1;
  slots_.resize(capacity);
  cells_.assign(blocks.size() * 512, kNone);
  for (size_t b = 0; b < blocks.size(); b++) {
    size_t slot = hash(blocks[b]) & mask_;
    while (slots_[slot].block != kEmpty) slot = (slot + 1) & mask_;
    slots_[slot] = {blocks[b], static_cast<uint32_t>(b * 512)};
  }
  for (size_t i = 0; i < keys.size(); i++) {
    const auto& k = keys[i];
    size_t slot = hash(blockKey(k[0] >> 3, k[1] >> 3, k[2] >> 3)) & mask_;
    while (slots_[slot].block != blockKey(k[0] >> 3, k[1] >> 3, k[2] >> 3))
      slot = (slot + 1) & mask_;
    cells_[slots_[slot].first + cellOf(k[0], k[1], k[2])] = static_cast<uint32_t>(i);
  }
}

std::vector<VoxelIndex::Offset> VoxelIndex::offsetsWithin(double radius) {
  const int r = static_cast<int>(std::floor(radius));
  std::vector<Offset> offsets;
  for (int z = -r; z <= r; z++)
    for (int y = -r; y <= r; y++)
      for (int x = -r; x <= r; x++)
        if (x * x + y * y + z * z <= radius * radius) offsets.push_back({x, y, z});
  std::stable_sort(offsets.begin(), offsets.end(), [](const Offset& a, const Offset& b) {
    return a[0] * a[0] + a[1] * a[1] + a[2] * a[2] < b[0] * b[0] + b[1] * b[1] + b[2] * b[2];
  });
  return offsets;
}

}  // namespace mrpt::fusion
