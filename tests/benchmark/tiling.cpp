// SPDX-License-Identifier: BSD-3-Clause
#include "tiling.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "fusion_octree/build.h"
#include "fusion_octree/files.h"
#include "fusion_octree/resampling.h"

namespace mrpt::fusion::benchmark {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kGridSide = 1U << mrpt::fusion::OcTreeCube::kMaxDepth;

class TilingVisitor {
 public:
  /** The original's node; above a block, null whatever it holds. */
  using State = const octomap::OcTreeNode*;

  TilingVisitor(const octomap::OcTree& map, const Tiles& tiles) : map_(map), tiles_(tiles) {}

  mrpt::fusion::OcTreeFill visit(const mrpt::fusion::OcTreeCube& cube, State node) const {
    using mrpt::fusion::OcTreeFill;
    if (cube.side() > Tiles::kBlock)
      return touchesTiles(cube) ? OcTreeFill::split() : OcTreeFill::unknown();
    if (!node) return OcTreeFill::unknown();
    return map_.nodeHasChildren(node) ? OcTreeFill::split() : OcTreeFill::leaf(node->getLogOdds());
  }

  State descend(State node, unsigned i, const mrpt::fusion::OcTreeCube& cube) const {
    if (cube.side() > Tiles::kBlock) return nullptr;
    if (cube.side() == Tiles::kBlock) return originalOf(cube);
    return mrpt::fusion::childOrSelf(map_, node, i);
  }

 private:
  bool touchesTiles(const mrpt::fusion::OcTreeCube& cube) const {
    for (unsigned axis = 0; axis < 3; axis++) {
      const uint32_t low = tiles_.first[axis];
      const uint32_t high = low + tiles_.copies[axis] * tiles_.period[axis];
      if (cube.key[axis] >= high || cube.key[axis] + cube.side() <= low) return false;
    }
    return true;
  }

  /** The node of the block that a block is a copy of, or the leaf that holds it. */
  State originalOf(const mrpt::fusion::OcTreeCube& block) const {
    if (!touchesTiles(block)) return nullptr;
    octomap::OcTreeKey key;
    for (unsigned axis = 0; axis < 3; axis++)
      key[axis] = static_cast<octomap::key_type>(
          tiles_.first[axis] + (block.key[axis] - tiles_.first[axis]) % tiles_.period[axis]);
    return map_.search(key, block.depth);
  }

  const octomap::OcTree& map_;
  Tiles tiles_;
};

}  // namespace

Tiles tilesFor(const octomap::OcTree& a, const octomap::OcTree& b, uint32_t nx, uint32_t ny) {
  std::array<uint32_t, 3> low{kGridSide, kGridSide, kGridSide}, high{};
  for (const octomap::OcTree* map : {&a, &b})
    for (auto leaf = map->begin_leafs(), end = map->end_leafs(); leaf != end; ++leaf)
      for (unsigned axis = 0; axis < 3; axis++) {
        const uint32_t begin = leaf.getIndexKey()[axis];
        const uint32_t side = kGridSide >> leaf.getDepth();
        low[axis] = std::min(low[axis], begin);
        high[axis] = std::max(high[axis], begin + side);
      }

  Tiles tiles;
  tiles.copies = {nx, ny, 1};
  for (unsigned axis = 0; axis < 3; axis++) {
    tiles.first[axis] = low[axis] / Tiles::kBlock * Tiles::kBlock;
    if (high[axis] > tiles.first[axis])
      tiles.period[axis] =
          (high[axis] - tiles.first[axis] + Tiles::kBlock - 1) / Tiles::kBlock * Tiles::kBlock;
    if (tiles.first[axis] + uint64_t{tiles.copies[axis]} * tiles.period[axis] > kGridSide)
      throw std::out_of_range("so many copies do not fit into an octree");
  }
  return tiles;
}

std::unique_ptr<octomap::OcTree> tileMap(const octomap::OcTree& map, const Tiles& tiles) {
  auto tiled = std::make_unique<octomap::OcTree>(map.getResolution());
  mrpt::fusion::OcTreeAccess::setSensorModel(*tiled, mrpt::fusion::OcTreeAccess::sensorModel(map));
  TilingVisitor visitor(map, tiles);
  mrpt::fusion::buildOcTree(*tiled, TilingVisitor::State{nullptr}, visitor);
  return tiled;
}

void writeTiledPair(const MapPair& pair, uint32_t nx, uint32_t ny, const std::string& folder) {
  fs::create_directories(folder);
  const auto b_in_a = mrpt::fusion::transformOcTree(*pair.b, pair.T_a_b, pair.a->getResolution());
  const Tiles tiles = tilesFor(*pair.a, *b_in_a, nx, ny);
  mrpt::fusion::saveOcTree(*tileMap(*pair.a, tiles), fs::path(folder) / "map_a.ot");
  // One large map at a time, and two where one becomes the other.
  mrpt::fusion::saveOcTree(
      *mrpt::fusion::transformOcTree(*tileMap(*b_in_a, tiles), pair.T_a_b.inverse(),
                                     pair.b->getResolution()),
      fs::path(folder) / "map_b.ot");
  fs::copy_file(fs::path(pair.folder) / "T_a_b.txt", fs::path(folder) / "T_a_b.txt",
                fs::copy_options::overwrite_existing);
}

}  // namespace mrpt::fusion::benchmark
