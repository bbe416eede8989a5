// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Merges two maps so that no observation counts twice. */
#include <mrpt/fusion/many_maps.h>

#include <utility>

#include "fusion_octree/walk.h"
#include "fusion_team/ledger/ledger.h"

namespace mrpt::fusion {
namespace {

/** True if a pose moves no point of a map by half a voxel. */
bool keepsItsPlace(const octomap::OcTree& map, const Eigen::Isometry3d& T) {
  const Eigen::AlignedBox3d box = knownSpace(map);
  if (box.isEmpty()) return true;
  for (int i = 0; i < 8; i++) {
    const Eigen::Vector3d corner = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
    if ((T * corner - corner).norm() >= 0.5 * map.getResolution()) return false;
  }
  return true;
}

/** Shares a map that the caller owns. */
std::shared_ptr<const octomap::OcTree> borrowed(const octomap::OcTree& map) {
  return {std::shared_ptr<const octomap::OcTree>(), &map};
}

}  // namespace

MergedSources mergeSources(const SourcedMap& a, const SourcedMap& b, const Eigen::Isometry3d& T_a_b,
                           const MergeParams& params, bool is_given) {
  const SourceName name_a{"a", {}}, name_b{"b", {}};
  const Source source_a(name_a, 0, borrowed(a.map), a.sources);
  const Source source_b(name_b, 0, borrowed(b.map), b.sources);
  MergedSources result;
  addSources(source_a.parts(), result.sources);
  addSources(source_b.parts(), result.sources);
  auto shares = sharesOf({&source_a.parts(), &source_b.parts()});
  const bool is_copy = source_a.contentHash() == source_b.contentHash();
  if (params.independent || (is_copy && is_given && !keepsItsPlace(b.map, T_a_b)))
    shares = {{}, {}};
  result.of_a = shares[0].counting;
  result.of_b = shares[1].counting;
  if (is_copy && result.of_b == Counting::None) result.of_b = Counting::Copy;
  if (result.of_a == Counting::All && result.of_b == Counting::All) {
    result.map = mergeMaps(a.map, b.map, T_a_b, params);
    return result;
  }
  Ledger ledger({params, name_a, false});
  ledger.add(source_a, Eigen::Isometry3d::Identity());
  ledger.add(source_b, T_a_b);
  result.map = std::make_unique<octomap::OcTree>(*ledger.map());
  return result;
}

}  // namespace mrpt::fusion
