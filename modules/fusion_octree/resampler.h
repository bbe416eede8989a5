// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "fusion_octree/block_tree.h"
#include "fusion_octree/cube.h"
#include "fusion_octree/cube_list.h"
#include "fusion_octree/work_budget.h"

/** \file
 * Inverse lookup of the cubes of a new grid in an octree. */

namespace mrpt::fusion {

/** Side of the key space, and key of the frame's origin, voxels. */
constexpr double kGridSide = 65536.0;
constexpr double kGridOrigin = 32768.0;

/** Looks up the cubes of a new grid in a source, from the root down. A copy for each thread. */
class Resampler {
 public:
  /** \param[in] source The source; must outlive this object.
   * \param[in] T_src_dst Pose of the new frame in the source's frame.
   * \param[in] source_resolution,resolution Voxel sizes of the source and of the new grid, m.
   * \param[in] budget Bound of the voxels that all copies look up. */
  Resampler(const BlockTree& source, const Eigen::Isometry3d& T_src_dst, double source_resolution,
            double resolution, const WorkBudget& budget);

  /** Returns the cubes of the new grid at a depth that may be known. */
  std::vector<OcTreeCube> cubesAt(unsigned depth);
  /** Adds the known space in a cube of cubesAt() to \a out. */
  void resample(const OcTreeCube& cube, CubeList& out);

 private:
  /** A node of the source with its cube. */
  struct Piece {
    uint32_t node;
    OcTreeCube cube;
  };
  /** The pieces that overlap a cube: a range of a stack. */
  struct Pieces {
    size_t begin, end;
    bool empty() const { return begin == end; }
  };
  /** Axis-aligned box in the source grid's units (voxels, from its lowest corner). */
  struct Box {
    Eigen::Vector3d low, high;
    double volumeIn(const OcTreeCube& c) const;
  };
  /** The blocks of the source in and around a cube. */
  struct Table {
    static constexpr int kSide = 8;  // blocks
    struct Entry {
      const float* values;  // of the voxels; of unknownValues() for an unknown block
      bool is_leaf;
    };
    std::array<int, 3> low{};   // the lowest block, in blocks of the source's grid
    std::array<int, 3> size{};  // in blocks, at most kSide
    std::array<Entry, size_t{kSide} * kSide * kSide> entries;  // x fastest
    std::deque<BlockTree::Values> leaves;  // room for the values of leaves, at fixed places
    size_t used_leaves = 0;
  };

  Box boxInSource(const OcTreeCube& cube) const;
  Pieces rootPieces();
  Pieces piecesIn(const Pieces& parent, const OcTreeCube& cube);
  void addPieces(const Piece& piece, const Box& box, double side);
  void visit(const OcTreeCube& cube, const Pieces& pieces, CubeList& out);
  template <class F>
  void visitAt(unsigned depth, const OcTreeCube& cube, const Pieces& pieces, F& f);
  bool isUniform(const Pieces& pieces) const;
  bool isCovered(const Box& box, const Pieces& pieces) const;
  bool makeTable(const Box& box, const Pieces& pieces);
  void addToTable(const BlockTree::Node& node, const OcTreeCube& cube);
  void visitInTable(const OcTreeCube& cube, CubeList& out);
  bool addIfOneValue(const OcTreeCube& cube, const Box& box, CubeList& out) const;
  void sample(const OcTreeCube& block, bool has_table, CubeList& out);
  /** Returns the share of a coordinate in the place of a voxel in the table: the number of the
   * block, then 6 bits for the voxel in the block.
   * \param[in] at Coordinate along the axis, voxels from the lowest corner of the table. */
  template <int axis>
  static constexpr int tableIndex(int at) {
    return ((at & 3) << (2 * axis)) + ((at >> 2) << (6 + 3 * axis));
  }
  float valueInTable(int index) const { return table_.entries[index >> 6].values[index & 63]; }
  void makeLines(const OcTreeCube& block);
  void sampleCentres(VoxelBlock& voxels) const;
  template <class Lookup>
  void sampleLattices(VoxelBlock& voxels, Lookup&& lookup) const;

  const BlockTree& source_;
  WorkBudget budget_;
  uint64_t work_per_voxel_;
  double scale_;
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d translation_;
  int samples_per_axis_;
  unsigned table_depth_;  // depth of the cubes with a table; more than the depth of blocks: none
  Eigen::Vector3d half_extent_per_side_;
  std::vector<Piece> stack_;
  Table table_;
  /** A sample along an axis of a block: its voxel, and its place in the voxel, in voxels. */
  struct Sample {
    double voxel, offset;
  };
  std::vector<Sample> samples_;
  /** The share of each axis of the new grid in each coordinate of a block's samples in the source:
   * lines_[row][axis][sample]. */
  std::array<std::array<std::vector<double>, 3>, 3> lines_;
};

}  // namespace mrpt::fusion
