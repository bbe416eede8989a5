// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Looks up the cubes of a new grid in an octree. */
#include "fusion_octree/resampler.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fusion_base/bits.h"

namespace mrpt::fusion {
namespace {

constexpr double kSamplesPerWork = 16;  // samples that take as long as to make a voxel
constexpr int kBlockSide = 4, kVoxels = VoxelBlock::kVoxels;

/** The voxels of a block that is unknown. */
const BlockTree::Values& unknownValues() {
  static const BlockTree::Values values = [] {
    BlockTree::Values v;
    v.fill(BlockTree::kUnknown);
    return v;
  }();
  return values;
}

/** Makes the voxels known whose values are numbers. No branch: a processor would often guess it
 * wrong. */
void markKnown(VoxelBlock& voxels) {
  uint64_t known = 0;
  for (unsigned i = VoxelBlock::kVoxels; i-- > 0;) {
    const float v = voxels.value[i];
    known = known << 1U | static_cast<unsigned>(std::abs(v) <= std::numeric_limits<float>::max());
  }
  voxels.known = known;
}

}  // namespace

double Resampler::Box::volumeIn(const OcTreeCube& c) const {
  double v = 1;
  for (unsigned axis = 0; axis < 3; axis++) {
    const double k = c.key[axis];
    v *= std::max(0.0, std::min(high[axis], k + c.side()) - std::max(low[axis], k));
  }
  return v;
}

Resampler::Resampler(const BlockTree& source, const Eigen::Isometry3d& T_src_dst,
                     double source_resolution, double resolution, const WorkBudget& budget)
    : source_(source), budget_(budget) {
  // From voxel units of the new grid to voxel units of the source grid.
  scale_ = resolution / source_resolution;
  rotation_ = T_src_dst.linear();
  translation_ = T_src_dst.translation() / source_resolution;
  samples_per_axis_ = std::max(1, static_cast<int>(std::ceil(scale_ - 1e-9)));
  work_per_voxel_ = 1 + static_cast<uint64_t>(std::pow(samples_per_axis_, 3) / kSamplesPerWork);
  half_extent_per_side_ = 0.5 * scale_ * rotation_.cwiseAbs().rowwise().sum();
  // A cube of 16 x 16 x 16 voxels of the source that is turned fits a table.
  table_depth_ = OcTreeCube::kMaxDepth - 4;
  for (double s = 1; s < scale_ && table_depth_ <= VoxelBlock::kDepth; s *= 2) table_depth_++;
  for (auto& row : lines_)
    for (auto& line : row) line.resize(static_cast<size_t>(kBlockSide) * samples_per_axis_);
  const int n = samples_per_axis_;
  for (int i = 0; i < kBlockSide * n; i++)
    samples_.push_back({static_cast<double>(i / n), (i % n + 0.5) / n});
}

std::vector<OcTreeCube> Resampler::cubesAt(unsigned depth) {
  std::vector<OcTreeCube> cubes;
  const auto add = [&](const OcTreeCube& cube, const Pieces&) { cubes.push_back(cube); };
  visitAt(depth, {}, rootPieces(), add);
  return cubes;
}

void Resampler::resample(const OcTreeCube& cube, CubeList& out) {
  OcTreeCube at;
  Pieces pieces = rootPieces();
  while (at.depth < cube.depth) {
    unsigned i = 0;
    while (!at.child(i).contains(cube)) i++;
    at = at.child(i);
    pieces = piecesIn(pieces, at);
  }
  visit(cube, pieces, out);
}

// Pieces. ----------------------------------------------------------------------------------------

Resampler::Box Resampler::boxInSource(const OcTreeCube& cube) const {
  Eigen::Vector3d centre = Eigen::Vector3d(cube.key[0], cube.key[1], cube.key[2]).array() +
                           0.5 * cube.side() - kGridOrigin;
  centre = (rotation_ * (centre * scale_) + translation_).array() + kGridOrigin;
  const Eigen::Vector3d half = half_extent_per_side_ * cube.side();
  return {centre - half, centre + half};
}

Resampler::Pieces Resampler::rootPieces() {
  stack_.clear();
  if (!source_.empty()) stack_.push_back({0, OcTreeCube{}});
  return {0, stack_.size()};
}

/** Puts the pieces in a cube on the stack, above the pieces of its parent. */
Resampler::Pieces Resampler::piecesIn(const Pieces& parent, const OcTreeCube& cube) {
  stack_.resize(parent.end);
  const Box box = boxInSource(cube);
  for (size_t i = parent.begin; i < parent.end; i++) {
    // A copy, because an addition can move the stack.
    // NOLINTNEXTLINE(performance-unnecessary-copy-initialization)
    const Piece piece = stack_[i];
    bool overlaps = true;
    for (unsigned axis = 0; axis < 3; axis++) {
      const double k = piece.cube.key[axis];
      overlaps = overlaps && box.low[axis] < k + piece.cube.side() && box.high[axis] > k;
    }
    if (overlaps) addPieces(piece, box, cube.side() * scale_);
  }
  return {parent.end, stack_.size()};
}

/** Adds the parts of \a piece that overlap \a box: leaves and blocks, or nodes no larger than
 * \a side. The piece itself overlaps the box. */
void Resampler::addPieces(const Piece& piece, const Box& box, double side) {
  const BlockTree::Node& node = source_.node(piece.node);
  if (piece.cube.side() <= side || node.kind != BlockTree::Kind::Inner) {
    stack_.push_back(piece);
    return;
  }
  // The children on the lower and on the upper side of each axis, one bit for each child.
  constexpr std::array<unsigned, 3> kLow{0x55, 0x33, 0x0F};
  const double half = 0.5 * piece.cube.side();
  unsigned children = node.children;
  for (unsigned axis = 0; axis < 3; axis++) {
    const double middle = piece.cube.key[axis] + half;
    if (!(box.low[axis] < middle)) children &= ~kLow[axis];
    if (!(box.high[axis] > middle)) children &= kLow[axis];
  }
  uint32_t number = node.first;
  unsigned before = 0;
  for (unsigned left = children; left; left &= left - 1) {
    const auto i = static_cast<unsigned>(lowestBit(left));
    for (; before < i; before++) number += node.children >> before & 1U;
    addPieces({number, piece.cube.child(i)}, box, side);
  }
}

bool Resampler::isUniform(const Pieces& pieces) const {
  const BlockTree::Node& first = source_.node(stack_[pieces.begin].node);
  for (size_t i = pieces.begin; i < pieces.end; i++) {
    const BlockTree::Node& node = source_.node(stack_[i].node);
    if (node.kind != BlockTree::Kind::Leaf || node.log_odds != first.log_odds) return false;
  }
  return true;
}

/** True if the box has no unknown space: the pieces fill it. Pieces do not overlap. */
bool Resampler::isCovered(const Box& box, const Pieces& pieces) const {
  double covered = 0;
  for (size_t i = pieces.begin; i < pieces.end; i++) covered += box.volumeIn(stack_[i].cube);
  return covered >= (box.high - box.low).prod() * (1 - 1e-9);
}

// Cubes. -----------------------------------------------------------------------------------------

template <class F>
void Resampler::visitAt(unsigned depth, const OcTreeCube& cube, const Pieces& pieces, F& f) {
  if (pieces.empty()) return;
  if (cube.depth == depth || (isUniform(pieces) && isCovered(boxInSource(cube), pieces)))
    return f(cube, pieces);
  for (unsigned i = 0; i < 8; i++) {
    const OcTreeCube child = cube.child(i);
    visitAt(depth, child, piecesIn(pieces, child), f);
  }
}

void Resampler::visit(const OcTreeCube& cube, const Pieces& pieces, CubeList& out) {
  if (pieces.empty()) return;
  const Box box = boxInSource(cube);
  if (isUniform(pieces) && isCovered(box, pieces))
    return out.addLeaf(cube, source_.node(stack_[pieces.begin].node).log_odds);
  if (addIfOneValue(cube, box, out)) return;
  if (cube.depth >= table_depth_ && makeTable(box, pieces))
    visitInTable(cube, out);
  else if (cube.depth == VoxelBlock::kDepth)
    sample(cube, false, out);
  else
    for (unsigned i = 0; i < 8; i++) {
      const OcTreeCube child = cube.child(i);
      visit(child, piecesIn(pieces, child), out);
    }
}

/** Adds a cube that is smaller than a voxel of the source, if all source voxels that it overlaps
 * have one value. \return False if they do not. */
bool Resampler::addIfOneValue(const OcTreeCube& cube, const Box& box, CubeList& out) const {
  if (cube.side() * scale_ > 1) return false;
  constexpr double kMargin = 1e-6;  // rounding may let the box touch one more voxel
  std::array<uint32_t, 3> low{}, high{};
  for (unsigned axis = 0; axis < 3; axis++) {
    const double margin = kMargin * (box.high[axis] - box.low[axis]);
    if (!(box.low[axis] >= 0 && box.high[axis] < kGridSide)) return false;
    low[axis] = static_cast<uint32_t>(box.low[axis] + margin);
    high[axis] = static_cast<uint32_t>(box.high[axis] - margin);
  }
  const float value = source_.at(low[0], low[1], low[2]);
  for (uint32_t z = low[2]; z <= high[2]; z++)
    for (uint32_t y = low[1]; y <= high[1]; y++)
      for (uint32_t x = low[0]; x <= high[0]; x++)
        if (source_.at(x, y, z) != value) return false;
  if (!std::isinf(value)) out.addLeaf(cube, value);
  return true;
}

// Tables. ----------------------------------------------------------------------------------------

/** Lists the blocks of the source in a box. \return False if there are too many of them, or if the
 * box leaves the source's grid. */
bool Resampler::makeTable(const Box& box, const Pieces& pieces) {
  constexpr double kMargin = 1e-6;  // voxels; more than the rounding of a sample
  for (unsigned axis = 0; axis < 3; axis++) {
    const double low = box.low[axis] - kMargin, high = box.high[axis] + kMargin;
    if (!(low >= 0 && high < kGridSide)) return false;
    table_.low[axis] = static_cast<int>(low) / kBlockSide;
    table_.size[axis] = static_cast<int>(high) / kBlockSide + 1 - table_.low[axis];
    if (table_.size[axis] > Table::kSide) return false;
  }
  for (int z = 0; z < table_.size[2]; z++)
    for (int y = 0; y < table_.size[1]; y++) {
      Table::Entry* const line = &table_.entries[(z * Table::kSide + y) * Table::kSide];
      std::fill(line, line + table_.size[0], Table::Entry{unknownValues().data(), false});
    }
  table_.used_leaves = 0;
  for (size_t p = pieces.begin; p < pieces.end; p++)
    addToTable(source_.node(stack_[p].node), stack_[p].cube);
  return true;
}

/** Adds the blocks of a node of the source, and of all nodes below it. */
void Resampler::addToTable(const BlockTree::Node& node, const OcTreeCube& cube) {
  std::array<int, 3> low{}, high{};  // blocks of the node in the table
  for (unsigned axis = 0; axis < 3; axis++) {
    const int first = (cube.key[axis] >> 2) - table_.low[axis];
    low[axis] = std::max(0, first);
    high[axis] = std::min(table_.size[axis], first + static_cast<int>(cube.side() >> 2));
    if (low[axis] >= high[axis]) return;
  }
  if (node.kind == BlockTree::Kind::Inner) {
    uint32_t child = node.first;
    for (unsigned i = 0; i < 8; i++)
      if (node.children >> i & 1U) addToTable(source_.node(child++), cube.child(i));
    return;
  }
  Table::Entry entry{nullptr, node.kind == BlockTree::Kind::Leaf};
  if (entry.is_leaf) {
    if (table_.used_leaves == table_.leaves.size()) table_.leaves.emplace_back();
    BlockTree::Values& leaf = table_.leaves[table_.used_leaves++];
    leaf.fill(node.log_odds);
    entry.values = leaf.data();
  } else {
    entry.values = node.values->data();
  }
  for (int z = low[2]; z < high[2]; z++)
    for (int y = low[1]; y < high[1]; y++)
      for (int x = low[0]; x < high[0]; x++)
        table_.entries[(z * Table::kSide + y) * Table::kSide + x] = entry;
}

/** As visit(), for a cube whose blocks are in the table. */
void Resampler::visitInTable(const OcTreeCube& cube, CubeList& out) {
  const Box box = boxInSource(cube);
  std::array<int, 3> low{}, high{};
  for (unsigned axis = 0; axis < 3; axis++) {
    low[axis] = std::max(0, static_cast<int>(box.low[axis]) / kBlockSide - table_.low[axis]);
    high[axis] = std::min(table_.size[axis] - 1,
                          static_cast<int>(box.high[axis]) / kBlockSide - table_.low[axis]);
  }
  const Table::Entry& first =
      table_.entries[(low[2] * Table::kSide + low[1]) * Table::kSide + low[0]];
  const float* const unknown = unknownValues().data();
  bool is_unknown = true, is_leaf = first.is_leaf;
  for (int z = low[2]; z <= high[2]; z++)
    for (int y = low[1]; y <= high[1]; y++)
      for (int x = low[0]; x <= high[0]; x++) {
        const Table::Entry& entry = table_.entries[(z * Table::kSide + y) * Table::kSide + x];
        is_unknown &= entry.values == unknown;
        is_leaf = is_leaf && entry.is_leaf && entry.values[0] == first.values[0];
      }
  if (is_unknown) return;
  if (is_leaf) return out.addLeaf(cube, first.values[0]);
  if (addIfOneValue(cube, box, out)) return;
  if (cube.depth == VoxelBlock::kDepth) return sample(cube, true, out);
  for (unsigned i = 0; i < 8; i++) visitInTable(cube.child(i), out);
}

// Samples. ---------------------------------------------------------------------------------------
// The sums of coordinates have the order of Eigen's product of a matrix and a vector, which decides
// their last bit: (x + y) + z for the first two rows, x + (y + z) for the third.

void Resampler::sample(const OcTreeCube& block, bool has_table, CubeList& out) {
  budget_.take(VoxelBlock::kVoxels * work_per_voxel_);
  VoxelBlock voxels;
  makeLines(block);
  if (!has_table)
    sampleLattices(voxels, [&](const std::array<double, 3>& p) {
      for (const double c : p)
        if (!(c >= 0 && c < kGridSide)) return BlockTree::kUnknown;
      return source_.at(static_cast<uint32_t>(p[0]), static_cast<uint32_t>(p[1]),
                        static_cast<uint32_t>(p[2]));
    });
  else if (samples_per_axis_ > 1)
    sampleLattices(voxels, [&](const std::array<double, 3>& p) {
      return valueInTable(tableIndex<0>(static_cast<int>(p[0]) - kBlockSide * table_.low[0]) +
                          tableIndex<1>(static_cast<int>(p[1]) - kBlockSide * table_.low[1]) +
                          tableIndex<2>(static_cast<int>(p[2]) - kBlockSide * table_.low[2]));
    });
  else
    sampleCentres(voxels);
  out.addBlock(block, voxels);
}

void Resampler::makeLines(const OcTreeCube& block) {
  for (unsigned axis = 0; axis < 3; axis++)
    for (size_t i = 0; i < samples_.size(); i++) {
      const double voxel = static_cast<double>(block.key[axis]) + samples_[i].voxel;
      const double p = (voxel + samples_[i].offset - kGridOrigin) * scale_;
      for (unsigned row = 0; row < 3; row++) lines_[row][axis][i] = rotation_(row, axis) * p;
    }
}

/** Looks up the centres of the voxels of a block. */
void Resampler::sampleCentres(VoxelBlock& voxels) const {
  constexpr int kPlane = kBlockSide * kBlockSide;
  std::array<int, VoxelBlock::kVoxels> index;
  for (int row = 0; row < 2; row++) {
    const double *const x = lines_[row][0].data(), *const y = lines_[row][1].data();
    const double *const z = lines_[row][2].data(), t = translation_[row];
    const int low = kBlockSide * table_.low[row];
    std::array<double, kPlane> plane;
    for (int i = 0; i < kPlane; i++) plane[i] = x[i % kBlockSide] + y[i / kBlockSide];
    for (int k = 0; k < kBlockSide; k++)
      for (int i = 0; i < kPlane; i++) {
        const int at = static_cast<int>(((plane[i] + z[k]) + t) + kGridOrigin) - low;
        if (row == 0)
          index[kPlane * k + i] = tableIndex<0>(at);
        else
          index[kPlane * k + i] += tableIndex<1>(at);
      }
  }
  const double *const x = lines_[2][0].data(), *const y = lines_[2][1].data();
  const double *const z = lines_[2][2].data(), t = translation_[2];
  const int low = kBlockSide * table_.low[2];
  std::array<double, VoxelBlock::kVoxels> yz;
  for (int i = 0; i < kVoxels; i++) yz[i] = y[i / kBlockSide % kBlockSide] + z[i / kPlane];
  for (int i = 0; i < kVoxels; i++)
    index[i] +=
        tableIndex<2>(static_cast<int>(((x[i % kBlockSide] + yz[i]) + t) + kGridOrigin) - low);
  for (unsigned i = 0; i < VoxelBlock::kVoxels; i++)
    voxels.value[i] = valueInTable(index[VoxelBlock::kRowIndex[i]]);
  markKnown(voxels);
}

/** Looks up a lattice of samples in each voxel of a block, and keeps the highest value.
 * \param[in] lookup Returns the value at a point of the source's grid, or kUnknown. */
template <class Lookup>
void Resampler::sampleLattices(VoxelBlock& voxels, Lookup&& lookup) const {
  const int n = samples_per_axis_;
  const auto valueAt = [&](int x, int y, int z) {
    std::array<double, 3> p;
    for (unsigned row = 0; row < 3; row++) {
      const auto& [along_x, along_y, along_z] = lines_[row];
      const double sum =
          row < 2 ? (along_x[x] + along_y[y]) + along_z[z] : along_x[x] + (along_y[y] + along_z[z]);
      p[row] = (sum + translation_[row]) + kGridOrigin;
    }
    return lookup(p);
  };
  for (unsigned i = 0; i < VoxelBlock::kVoxels; i++) {
    const auto row = static_cast<int>(VoxelBlock::kRowIndex[i]);
    const int low[3] = {row % kBlockSide * n, row / kBlockSide % kBlockSide * n,
                        row / kBlockSide / kBlockSide * n};
    float highest = BlockTree::kUnknown;
    for (int z = low[2]; z < low[2] + n; z++)
      for (int y = low[1]; y < low[1] + n; y++)
        for (int x = low[0]; x < low[0] + n; x++) highest = std::max(highest, valueAt(x, y, z));
    voxels.value[i] = highest;
  }
  markKnown(voxels);
}

}  // namespace mrpt::fusion
