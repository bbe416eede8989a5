// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "fusion_base/bits.h"
#include "fusion_core/map/voxel_blocks.h"

/** \file
 * Mean and covariance of the voxels around a voxel, from the masks of their blocks. */

namespace mrpt::fusion {

/** Sums over cells of a block of 4x4x4 voxels, of their coordinates (0 to 3) in the block. */
struct CellSums {
  Four xyz = {};       ///< Sums of x, y, z, and number of cells
  Four squares = {};   ///< Sums of xx, yy, zz
  Four products = {};  ///< Sums of xy, xz, yz

  static constexpr CellSums ofCell(int cell) {
    const auto at = VoxelBlocks::coordinatesOf(cell);
    const auto x = static_cast<float>(at[0]), y = static_cast<float>(at[1]),
               z = static_cast<float>(at[2]);
    return {Four{x, y, z, 1}, Four{x * x, y * y, z * z, 0}, Four{x * y, x * z, y * z, 0}};
  }
  constexpr void operator+=(const CellSums& o) {
    xyz += o.xyz;
    squares += o.squares;
    products += o.products;
  }
};

/** Sums of all subsets of 8 consecutive cells of a block. With this table the sums of a block need
 * no branch. */
inline constexpr auto kSumsOfEight = [] {
  std::array<std::array<CellSums, 256>, 8> sums{};
  for (unsigned eight = 0; eight < 8; eight++)
    for (unsigned cells = 1; cells < 256; cells++) {
      const auto first = static_cast<unsigned>(lowestBit(cells));
      sums[eight][cells] = sums[eight][cells & (cells - 1)];
      sums[eight][cells] += CellSums::ofCell(static_cast<int>(8 * eight + first));
    }
  return sums;
}();

/** Mean and covariance of a set of offsets. The sums are whole numbers: they are exact in any
 * order, up to 2^24. The sums of a ball of 20 voxels stay below 2^24. */
class Moments {
 public:
  /** Adds the offsets of a block's voxels.
   * \param[in] cells Mask of the voxels.
   * \param[in] offset Offset of the block's lowest cell. */
  void add(uint64_t cells, const VoxelBlocks::Offset& offset) {
    CellSums in_block;
    for (size_t eight = 0; eight < 8; eight++)
      in_block += kSumsOfEight[eight][cells >> (8 * eight) & 255U];
    const Four o = {static_cast<float>(offset[0]), static_cast<float>(offset[1]),
                    static_cast<float>(offset[2]), 0};
    const Four from_block = in_block.xyz;
    const Four from_origin = from_block + from_block[3] * o;
    sums_.xyz += from_origin;
    sums_.squares += in_block.squares + (from_block + from_origin) * o;
    const auto first = [](const Four& v) { return __builtin_shufflevector(v, v, 0, 0, 1, 3); };
    const auto second = [](const Four& v) { return __builtin_shufflevector(v, v, 1, 2, 2, 3); };
    sums_.products +=
        in_block.products + first(from_block) * second(o) + second(from_origin) * first(o);
  }
  size_t size() const { return static_cast<size_t>(sums_.xyz[3]); }
  Eigen::Vector3d mean() const { return toVector(sums_.xyz) / static_cast<double>(sums_.xyz[3]); }
  Eigen::Matrix3d covariance() const {
    const Eigen::Vector3d square = toVector(sums_.squares), product = toVector(sums_.products);
    Eigen::Matrix3d squares;
    squares << square.x(), product.x(), product.y(), product.x(), square.y(), product.z(),
        product.y(), product.z(), square.z();
    const Eigen::Vector3d m = mean();
    return squares / static_cast<double>(sums_.xyz[3]) - m * m.transpose();
  }

 private:
  static Eigen::Vector3d toVector(const Four& v) { return {v[0], v[1], v[2]}; }
  CellSums sums_;
};

/** Returns the moments of the voxels within a ball around a voxel. */
inline Moments momentsAround(const VoxelBlocks& blocks, const VoxelBlocks::Ball& ball,
                             const octomap::OcTreeKey& key) {
  Moments moments;
  blocks.forEachBlockAround(placeOf(key), ball,
                            [&](uint64_t cells, const VoxelBlocks::Offset& lowest) {
                              moments.add(cells, lowest);
                              return false;
                            });
  return moments;
}

}  // namespace mrpt::fusion
