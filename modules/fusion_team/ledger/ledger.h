// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/merging.h>
#include <octomap/OcTree.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "fusion_team/ledger/identity.h"
#include "fusion_team/ledger/source.h"

/** \file
 * The fused map as a function of its sources and their poses. */

namespace mrpt::fusion {

/** Settings of a ledger. */
struct LedgerParams {
  MergeParams merge;  ///< Rule for voxels that several sources know
  /** Source that comes first in the order of the combination, if the ledger holds it. All other
   * sources follow in the order of their names. */
  std::optional<SourceName> reference;
  /** If true, all sources count. If false, no observation counts twice, see sharesOf(). */
  bool independent = false;
};

/** What Ledger::add() did. */
enum class AddResult {
  Added,        ///< The source is new
  Duplicate,    ///< The ledger holds this version of the source already; nothing changed
  SameContent,  ///< The ledger keeps the source, but another source has the same voxels. Only one
                ///< of them counts
  Replaced,     ///< The source is a newer version and replaces the older version
  Older         ///< The ledger holds or has removed a newer version; nothing changed
};

/** A source in a ledger. */
struct LedgerEntry {
  Source source;                          ///< The source
  std::optional<Eigen::Isometry3d> pose;  ///< Pose of the source's frame in the fused map's frame;
                                          ///< empty if the source is not placed
  Counting counting = Counting::None;     ///< How the source counts, if it is placed
  std::optional<SourceName> with;         ///< Source with the same observations, if not all count

  /** True if all observations of the source are in the fused map. */
  bool counts() const { return pose && counting == Counting::All; }
};

/** The sources of a fused map.
 *
 * The fused map is a pure function of the sources, their poses and the settings. The order of the
 * calls, duplicates and late arrivals do not change a bit of it. The sources are combined in one
 * order: the reference first, then by name. See combineLogOdds().
 *
 * No observation counts twice: sources with the same voxels count once, and a fused map among the
 * sources adds only what its parts have not added, see sharesOf().
 *
 * The first source that counts gives resolution and sensor model. If its pose is the identity, its
 * octree is used as it is; all others are resampled, see transformOcTree(). So the map of two
 * sources is mergeMaps() of both.
 *
 * The ledger keeps the resampled octree of each source that counts, and the fused map. A change
 * costs the resampling of the sources that changed, and the computation of the blocks that they
 * touch before or after the change. The other blocks are copied. If the first source changes its
 * resolution or sensor model, all is computed anew.
 *
 * Several threads may call const functions at once. */
class Ledger {
 public:
  explicit Ledger(LedgerParams params = {}) : params_(std::move(params)) {}

  /** Adds a source, or replaces an older version of it.
   *
   * Versions are ordered by sequence, then by content hash. The pose of a duplicate is ignored:
   * move() corrects poses.
   * \param[in] source The source.
   * \param[in] T_fused_source Pose in the frame of the fused map. Empty: the source is not placed.
   * \exception std::invalid_argument If the pose is not finite; nothing changes. */
  AddResult add(Source source, const std::optional<Eigen::Isometry3d>& T_fused_source);
  /** Removes a source. Its version and older versions that arrive later are AddResult::Older.
   * \return False if the ledger does not hold the source. */
  bool remove(const SourceName& name);
  /** Removes all versions of a source up to a sequence, also versions that arrive later.
   * \return False if the ledger does not hold such a version now. */
  bool remove(const SourceName& name, uint64_t up_to_sequence);
  /** Changes the pose of a source. An empty pose takes the source out of the fused map, and the
   * ledger keeps the source.
   * \return False if the ledger does not hold the source.
   * \exception std::invalid_argument If the pose is not finite; nothing changes. */
  bool move(const SourceName& name, const std::optional<Eigen::Isometry3d>& T_fused_source);

  /** True if the ledger holds a source with this octree, the same object, and these sources. */
  bool holds(const SourceName& name, const std::shared_ptr<const octomap::OcTree>& map,
             Sources parts) const;
  /** Returns all sources in the order of the combination. */
  std::vector<LedgerEntry> entries() const;
  /** Returns the fused map, null if no source is placed. The octree does not change afterwards: a
   * later call returns another octree if something changed.
   * \exception std::exception "<robot>: <reason>" if a source cannot be resampled, see
   * transformOcTree(). The ledger keeps its state. Remove or move the source. */
  std::shared_ptr<const octomap::OcTree> map();

 private:
  struct Version {
    uint64_t sequence, content_hash;
    bool operator<(const Version& o) const {
      return std::tie(sequence, content_hash) < std::tie(o.sequence, o.content_hash);
    }
  };
  /** A source, and its octree on the grid of the fused map. */
  struct Slot {
    Source source;
    std::optional<Eigen::Isometry3d> pose;
    std::shared_ptr<const octomap::OcTree> on_grid;  // null if it must be computed
    bool is_resampled = false;                       // false if on_grid is the source's octree
    bool in_use = false;                             // true if the fused map needs on_grid
  };
  /** Order of the combination. */
  struct Order {
    std::optional<SourceName> reference;
    bool operator()(const SourceName& a, const SourceName& b) const {
      if (reference && (a == *reference) != (b == *reference)) return a == *reference;
      return a < b;
    }
  };
  /** The part that a source has in the fused map. */
  struct Part {
    std::shared_ptr<const octomap::OcTree> octree;
    bool counts;  // false if it only fills unknown space
    bool operator!=(const Part& o) const { return octree != o.octree || counts != o.counts; }
  };
  using Parts = std::map<SourceName, Part, Order>;

  std::vector<std::pair<SourceName, Share>> shares() const;
  void putOnGrid(const std::vector<Slot*>& slots) const;

  LedgerParams params_;
  std::map<SourceName, Slot, Order> slots_{Order{params_.reference}};
  std::map<SourceName, uint64_t> removed_;  // highest sequence that was removed
  std::shared_ptr<const octomap::OcTree> fused_;
  Parts fused_from_{Order{params_.reference}};  // parts of fused_
};

}  // namespace mrpt::fusion
