// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * CObservationMapDiff: serialization and description. */

#include <mrpt/obs/CObservationLocalMap.h>
#include <mrpt/serialization/CArchive.h>

#include <ostream>

#include "fusion_base/printable.h"
#include "fusion_link/map_index.h"
#include "fusion_link/pieces.h"
#include "mrpt_fusion_maps/archives/blobs.h"
#include "mrpt_fusion_maps/archives/guarded_archive.h"

using namespace mrpt::fusion;
using namespace mrpt::obs;

IMPLEMENTS_SERIALIZABLE(CObservationMapDiff, CObservation, mrpt::obs)

namespace {

/** Largest size of an index: it goes over the link in pieces. */
constexpr size_t kMostIndexBytes = kMostPieces * (kMostSampleBytes - sizeof(uint16_t));

/** Reads a blob. \exception std::exception If it has more bytes than allowed. */
std::string readBlobUpTo(mrpt::serialization::CArchive& in, size_t most) {
  const auto size = in.ReadAs<uint64_t>();
  if (size > most) THROW_EXCEPTION("CObservationMapDiff: corrupt stream: a field is too large");
  return readBytes(in, size);
}

/** Takes what small input unpacks to from the budget of a file.
 * \param[in] count Number of nodes, or of entries of an index. \param[in] bytes Bytes that hold
 * them. */
void charge(size_t count, size_t bytes, ReadingBudget& budget) {
  if (count > budget.mostNodes(bytes))
    THROW_EXCEPTION("CObservationMapDiff: corrupt stream: it has too many nodes for its size");
  budget.take(count, bytes);
}

size_t entriesOf(const MapIndex& index) { return index.blocks.size() + index.trunk.values.size(); }

CObservationMapDiff::Block readBlock(GuardedArchive& in) {
  CObservationMapDiff::Block block;
  in >> block.cube >> block.version;
  block.nodes = readBlobUpTo(in, kMostSampleBytes);
  charge(checkBlock(block.cube, block.nodes), block.nodes.size(), in.budget());
  return block;
}

}  // namespace

uint8_t CObservationMapDiff::serializeGetVersion() const { return 0; }

void CObservationMapDiff::serializeTo(mrpt::serialization::CArchive& out) const {
  out << timestamp;
  writeBlob(out, sensorLabel);
  out << version;
  writeBlob(out, index);
  out << static_cast<uint64_t>(blocks.size());
  for (const Block& block : blocks) {
    out << block.cube << block.version;
    writeBlob(out, block.nodes);
  }
  writeEndMark(out);
}

void CObservationMapDiff::serializeFrom(mrpt::serialization::CArchive& in, uint8_t version_read) {
  if (version_read > 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version_read);
  CObservationMapDiff read;  // this object stays as it was if the stream ends early
  GuardedArchive guarded(in);
  guarded >> read.timestamp;
  read.sensorLabel = readBlob(guarded);
  guarded >> read.version;
  read.index = readBlobUpTo(guarded, kMostIndexBytes);
  charge(entriesOf(indexOf(read.index)), read.index.size(), guarded.budget());
  const auto count = guarded.ReadAs<uint64_t>();
  if (count > kMostBlocks) THROW_EXCEPTION("CObservationMapDiff: corrupt stream: too many blocks");
  for (uint64_t i = 0; i < count; i++) read.blocks.push_back(readBlock(guarded));
  readEndMark(guarded);
  *this = std::move(read);
}

void CObservationMapDiff::getSensorPose(mrpt::poses::CPose3D& out_sensorPose) const {
  out_sensorPose = mrpt::poses::CPose3D();
}
void CObservationMapDiff::setSensorPose(const mrpt::poses::CPose3D&) {}

void CObservationMapDiff::getDescriptionAsText(std::ostream& o) const {
  CObservationMapDiff copy;
  copy.timestamp = timestamp;
  copy.sensorLabel = printable(sensorLabel);
  copy.CObservation::getDescriptionAsText(o);
  size_t bytes = index.size();
  for (const Block& block : blocks) bytes += block.nodes.size();
  o << "Changes of the map of robot '" << copy.sensorLabel << "', version " << version << "\n"
    << "Blocks that have changed: " << blocks.size() << ", " << bytes << " bytes with the index\n";
}
