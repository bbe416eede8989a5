// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Inserts scans into octrees. */

#include "fusion_octree/insertion/scan_insertion.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <utility>

#include "fusion_base/parallel.h"
#include "fusion_octree/build.h"
#include "fusion_octree/insertion/cell_marks.h"
#include "fusion_octree/insertion/cell_window.h"
#include "fusion_octree/insertion/ray_walk.h"
#include "fusion_octree/insertion/scan_rays.h"
#include "fusion_octree/insertion/tree_update.h"

namespace mrpt::fusion {
namespace {

using octomap::OcTree;
using octomap::point3d;

/** Walks along rays and marks their voxels, on one thread. */
struct Worker {
  RayWalker walker;
  CellMarks marks;
};

/** The steps of an insertion, with their memory. */
class Insertion {
 public:
  /** \return False if octomap must insert the scan. The octree is not changed then. */
  bool insert(OcTree& tree, const std::vector<point3d>& ends, const point3d& origin_point,
              double max_range, bool prune) {
    const RayOrigin origin(tree, origin_point);
    const CellBox box = makeChunks(ends, origin, max_range);
    if (box.empty()) return true;
    if (!window_.cover(box)) return false;
    if (!markVoxels(origin)) return false;
    std::vector<const CellMarks*> marks;
    for (const auto& worker : workers_) marks.push_back(&worker.marks);
    updater_.update(tree, window_, marks, prune);
    return true;
  }

  /** Returns the memory of the object, bytes. */
  size_t bytes() const {
    size_t bytes = chunks_.capacity() * sizeof(RayChunk) + updater_.bytes();
    for (const auto& worker : workers_) bytes += worker.marks.bytes();
    return bytes;
  }

 private:
  /** Makes the rays. \return The box of their voxels. Empty: no voxel changes. */
  CellBox makeChunks(const std::vector<point3d>& ends, const RayOrigin& origin, double max_range) {
    chunk_count_ = (ends.size() + RayChunk::kMost - 1) / RayChunk::kMost;
    if (chunks_.size() < chunk_count_) chunks_.resize(chunk_count_);
    forEachIndex(chunk_count_, 4, [&](size_t i) {
      const size_t first = i * RayChunk::kMost;
      makeRays(ends.data() + first, std::min(RayChunk::kMost, ends.size() - first), origin,
               max_range, chunks_[i]);
    });
    CellBox box;
    for (size_t i = 0; i < chunk_count_; i++) box.add(chunks_[i].box);
    if (!box.empty() && origin.in_grid) box.add({origin.key, origin.key});
    return box;
  }

  /** Marks the voxels of the rays. Each worker takes the next chunk. Which worker marks a voxel
   * makes no difference. \return False if a ray leaves the window. */
  bool markVoxels(const RayOrigin& origin) {
    const auto threads = static_cast<size_t>(tbb::this_task_arena::max_concurrency());
    workers_.resize(std::max(workers_.size(), std::min(threads, chunk_count_)));
    for (auto& worker : workers_) worker.marks.clear(0);
    std::atomic<size_t> next{0};
    std::atomic<bool> inside{true};
    forEachIndex(std::min(threads, chunk_count_), 1, [&](size_t w) {
      Worker& worker = workers_[w];
      for (size_t i = next++; i < chunk_count_; i = next++) {
        if (worker.marks.numbers().empty()) worker.marks.clear(window_.blocks());
        if (!worker.walker.walk(chunks_[i], origin, window_, worker.marks)) inside = false;
      }
    });
    return inside;
  }

  std::vector<RayChunk> chunks_;
  size_t chunk_count_ = 0;
  CellWindow window_;
  std::vector<Worker> workers_;
  TreeUpdater updater_;
};

/** Keeps the memory of insertions for the next insertions, because new memory costs more time than
 * a scan. There are as many objects as insertions at the same time. */
class InsertionPool {
 public:
  std::unique_ptr<Insertion> take() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (free_.empty()) return std::make_unique<Insertion>();
    auto insertion = std::move(free_.back());
    free_.pop_back();
    return insertion;
  }
  void giveBack(std::unique_ptr<Insertion> insertion) {
    constexpr size_t kMostBytes = size_t{1} << 26U;
    if (insertion->bytes() > kMostBytes) return;
    const std::lock_guard<std::mutex> lock(mutex_);
    free_.push_back(std::move(insertion));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Insertion>> free_;
};

InsertionPool& pool() {
  static InsertionPool pool;
  return pool;
}

bool insertBlocks(OcTree& tree, const std::vector<point3d>& ends, const point3d& origin,
                  double max_range, bool prune) {
  auto insertion = pool().take();
  const bool done = insertion->insert(tree, ends, origin, max_range, prune);
  pool().giveBack(std::move(insertion));
  return done;
}

/** Returns whether no node below a node has 8 equal leaves as children. */
bool isPrunedBelow(const OcTree& tree, const octomap::OcTreeNode& node) {
  for (unsigned i = 0; i < 8; i++) {
    if (!tree.nodeChildExists(&node, i)) continue;
    const octomap::OcTreeNode& child = *tree.getNodeChild(&node, i);
    if (tree.nodeHasChildren(&child) &&
        (tree.isNodeCollapsible(&child) || !isPrunedBelow(tree, child)))
      return false;
  }
  return true;
}

}  // namespace

InnerNodes finishLazyUpdates(OcTree& tree, bool prune, InnerNodes before_updates) {
  tree.updateInnerOccupancy();
  if (!prune) return InnerNodes::Current;
  tree.prune();
  // octomap stops pruning at the first depth without equal leaves. So trees that were not pruned
  // before may keep some.
  const bool pruned = before_updates == InnerNodes::Pruned || !tree.getRoot() ||
                      isPrunedBelow(tree, *tree.getRoot());
  return pruned ? InnerNodes::Pruned : InnerNodes::Current;
}

InnerNodes insertScan(OcTree& tree, const std::vector<point3d>& ends, const point3d& origin,
                      double max_range, bool prune, InnerNodes inner_nodes) {
  const bool known =
      inner_nodes == InnerNodes::Pruned || (inner_nodes == InnerNodes::Current && !prune);
  if (known && !tree.bbxSet() && !OcTreeAccess::recordsChanges(tree) &&
      insertBlocks(tree, ends, origin, max_range, prune))
    return prune ? InnerNodes::Pruned : InnerNodes::Current;
  octomap::Pointcloud cloud;
  cloud.reserve(ends.size());
  for (const auto& end : ends) cloud.push_back(end);
  tree.insertPointCloud(cloud, origin, max_range, true);
  return finishLazyUpdates(tree, prune, inner_nodes);
}

}  // namespace mrpt::fusion
