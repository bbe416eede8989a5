// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Makes diffs of maps, and adds them up. */

#include "mrpt_fusion_maps/map_diffs.h"

#include <memory>
#include <random>
#include <utility>

#include "fusion_base/byte_reader.h"
#include "fusion_link/pieces.h"
#include "fusion_link/sent_map.h"

using mrpt::obs::CObservationMapDiff;

namespace mrpt::fusion {

MapReplica emptyReplicaOf(const CObservationMapDiff& diff) {
  return MapReplica({diff.sensorLabel, {}});
}

void addDiff(const CObservationMapDiff& diff, MapReplica& map) {
  const bool is_whole = indexOf(diff.index).blocks.size() == diff.blocks.size();
  MapReplica result = is_whole ? emptyReplicaOf(diff) : map;
  const SourceName& source = map.source();
  auto samples = cutIntoPieces(source, SampleKind::Index, diff.version, diff.index);
  for (const auto& block : diff.blocks)
    samples.push_back({{source, SampleKind::Block, block.cube}, block.version, block.nodes});
  result.add(samples);
  if (result.missing().empty() && result.completeVersion() == 0)
    corrupt("a diff of a map is corrupt: its blocks are not those of its index");
  map = std::move(result);
}

/** The map of which diffs were made. */
class MapDiffs::Sent {
 public:
  explicit Sent(const std::string& robot)
      : replica_({robot, {}}), map_(replica_, std::random_device()()) {}

  CObservationMapDiff::Ptr next(const octomap::OcTree& map) {
    const uint64_t before = replica_.completeVersion();
    for (const Sample& sample : map_.update(std::make_shared<const octomap::OcTree>(map)))
      if (sample.key.kind != SampleKind::Outline) replica_.add(sample);
    const auto diff = diffSince(replica_, before);
    return diff ? observationOf(*diff) : nullptr;
  }

 private:
  MapReplica replica_;
  SentMap map_;
};

MapDiffs::MapDiffs(const std::string& robot) : m_sent(std::make_unique<Sent>(robot)) {}
MapDiffs::~MapDiffs() = default;

CObservationMapDiff::Ptr MapDiffs::next(const octomap::OcTree& map) { return m_sent->next(map); }

}  // namespace mrpt::fusion
