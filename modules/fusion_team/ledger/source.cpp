// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Makes sources. */
#include "fusion_team/ledger/source.h"

#include <stdexcept>
#include <utility>

#include "fusion_octree/voxel_hash.h"

namespace mrpt::fusion {

Source::Source(SourceName name, uint64_t sequence, std::shared_ptr<const octomap::OcTree> map,
               Sources parts)
    : name_(std::move(name)),
      sequence_(sequence),
      map_(std::move(map)),
      content_hash_(0),
      parts_(std::move(parts)) {
  if (!map_) throw std::invalid_argument("a source needs a map");
  content_hash_ = voxelHash(*map_);
  if (parts_.empty()) parts_.push_back({{}, {}, 0, content_hash_});
  for (SourceId& part : parts_)
    if (part.content_hash == 0) part.content_hash = content_hash_;
}

}  // namespace mrpt::fusion
