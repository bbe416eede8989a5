// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "fusion_link/map_blocks.h"
#include "fusion_link/map_index.h"
#include "fusion_link/pieces.h"
#include "fusion_team/link/link.h"

/** \file
 * What a robot has of one map: its own map, or the map of another robot. */

namespace mrpt::fusion {

/** The samples of one map that have arrived, the latest of each key. The order in which they
 * arrive, and duplicates, do not matter. */
class MapReplica {
 public:
  /** \param[in] source Name of the map.
   * \param[in] most_bytes Largest number of bytes of all samples. */
  explicit MapReplica(SourceName source, size_t most_bytes = kMostBytes)
      : source_(std::move(source)), most_bytes_(most_bytes) {}

  /** Largest number of bytes: 100 times a large building. */
  static constexpr size_t kMostBytes = size_t{64} << 20U;

  /** Adds a sample of the map: index, outline or block.
   * \return False if a sample of the same key is as new: nothing changed.
   * \exception std::runtime_error If the sample is damaged or too much: nothing changed. */
  bool add(const Sample& sample);
  /** Adds samples that come together. Whether the map is whole is found out once, at their end.
   * \exception std::runtime_error If a sample is damaged or too much. The samples before it stay, the
   * samples behind it are not added. */
  void add(const std::vector<Sample>& samples);

  const SourceName& source() const { return source_; }  ///< Name of the map
  /** Returns the newest index that has arrived. */
  const std::optional<MapIndex>& index() const { return index_; }
  /** Returns the blocks of the index whose version has not arrived. */
  const std::set<BlockCode>& missing() const { return missing_; }
  /** Returns the version of the map that is here as a whole; 0 if there is none. */
  uint64_t completeVersion() const { return complete_version_; }
  /** Returns the highest version of all samples. */
  uint64_t highestVersion() const { return highest_version_; }
  /** Returns the number of bytes of all samples and their keys. */
  size_t bytes() const;
  /** Returns the blocks of the index that are here, and its trunk. Nothing without an index. While
   * the map is not complete, some blocks may be of other versions. */
  std::optional<MapBlocks> blocks() const;
  /** Returns the outline that has arrived. */
  std::optional<std::string> outline() const;
  /** Returns all samples. */
  std::vector<Sample> samples() const;
  /** Returns the version of a block that is here; 0 if it is not here. */
  uint64_t versionOf(BlockCode code) const;

 private:
  struct Held {
    uint64_t version;
    BlockBytes bytes;
  };

  bool take(const Sample& sample);
  bool addBlock(const Sample& sample);
  bool addIndex(const Sample& sample);
  void update(BlockCode code);
  void finish();

  SourceName source_;
  size_t most_bytes_;
  Pieces index_pieces_, outline_pieces_;
  std::map<BlockCode, Held> blocks_;
  std::optional<MapIndex> index_;
  std::set<BlockCode> missing_;
  uint64_t complete_version_ = 0, highest_version_ = 0;
  size_t block_bytes_ = 0;  // bytes of all blocks and their keys
};

}  // namespace mrpt::fusion
