// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * CObservationLocalMap: serialization and description. */

#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/obs/CObservationLocalMap.h>
#include <mrpt/serialization/CArchive.h>

#include <iostream>

#include "fusion_base/printable.h"
#include "fusion_octree/build.h"
#include "fusion_octree/compression.h"
#include "mrpt_fusion_maps/archives/blobs.h"
#include "mrpt_fusion_maps/archives/map_reader.h"
#include "mrpt_fusion_maps/archives/packed_nodes.h"
#include "mrpt_fusion_maps/archives/poses.h"
#include "mrpt_fusion_maps/archives/sources.h"

using namespace mrpt::fusion;
using namespace mrpt::obs;
using mrpt::maps::CMetricMap;
using mrpt::maps::CProbOctoMap;

IMPLEMENTS_SERIALIZABLE(CObservationLocalMap, CObservation, mrpt::obs)

namespace {

/** The kind of map in a stream. */
enum class Content : uint8_t { None, OcTree, Other };

/** Returns a map without the nodes. */
CProbOctoMap withoutNodes(const CProbOctoMap& map) {
  CProbOctoMap hull(map.getResolution());
  hull.genericMapParams = map.genericMapParams;
  hull.insertionOptions = map.insertionOptions;
  hull.likelihoodOptions = map.likelihoodOptions;
  hull.renderingOptions = map.renderingOptions;
  SourcesOfMap::copy(map, hull);
  OcTreeAccess::setSensorModel(hull.octree(), OcTreeAccess::sensorModel(map.octree()));
  return hull;
}

void writeMap(mrpt::serialization::CArchive& out, const CMetricMap* map, Packing packing) {
  if (const auto* octomap = dynamic_cast<const CProbOctoMap*>(map)) {
    out << static_cast<uint8_t>(Content::OcTree) << withoutNodes(*octomap);
    writeBlob(out, compressNodes(octomap->octree(), packing));
  } else if (map) {
    out << static_cast<uint8_t>(Content::Other) << *map;
  } else {
    out << static_cast<uint8_t>(Content::None);
  }
}

/** Reads a map. \param[out] packing The packing of a CProbOctoMap. */
CMetricMap::Ptr readContent(GuardedArchive& in, Packing& packing) {
  uint8_t content = 0;
  in >> content;
  switch (static_cast<Content>(content)) {
    case Content::None:
      return nullptr;
    case Content::OcTree: {
      auto octomap = std::make_shared<CProbOctoMap>();
      in >> *octomap;
      packing = readPackedNodes(in, octomap->octree());
      return octomap;
    }
    case Content::Other:
      return readMap(in, in.readHeader());
  }
  THROW_EXCEPTION("CObservationLocalMap: corrupt stream: unknown kind of map");
}

}  // namespace

CObservationLocalMap::CObservationLocalMap() { pose.cov.setDiagonal(6, 1e6); }

// Version 0: all octrees are packed by LZMA.
uint8_t CObservationLocalMap::serializeGetVersion() const { return 1; }

void CObservationLocalMap::serializeTo(mrpt::serialization::CArchive& out) const {
  out << timestamp;
  writeBlob(out, sensorLabel);
  out << sequence << pose;
  writeMap(out, map.get(), smallest ? Packing::Smallest : Packing::Fast);
  writeEndMark(out);
}

void CObservationLocalMap::serializeFrom(mrpt::serialization::CArchive& in, uint8_t version) {
  if (version > 1) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  CObservationLocalMap read;  // this object stays as it was if the stream ends early
  GuardedArchive guarded(in);
  guarded >> read.timestamp;
  read.sensorLabel = readBlob(guarded);
  guarded >> read.sequence >> read.pose;
  checkPose(read.pose);
  Packing packing = Packing::Fast;
  read.map = readContent(guarded, packing);
  read.smallest = packing == Packing::Smallest;
  readEndMark(guarded);
  *this = std::move(read);
}

void CObservationLocalMap::getSensorPose(mrpt::poses::CPose3D& out_sensorPose) const {
  out_sensorPose = pose.mean;
}
void CObservationLocalMap::setSensorPose(const mrpt::poses::CPose3D& newSensorPose) {
  pose.mean = newSensorPose;
}

void CObservationLocalMap::getDescriptionAsText(std::ostream& o) const {
  CObservationLocalMap copy(*this);  // shares the map
  copy.sensorLabel = printable(sensorLabel);
  copy.CObservation::getDescriptionAsText(o);
  o << "Map number " << sequence << " of robot '" << copy.sensorLabel << "'\n"
    << "Pose guess in the common frame: " << pose << "\n"
    << "Map: " << (map ? map->asString() : "none") << "\n";
  if (const auto* octomap = dynamic_cast<const CProbOctoMap*>(map.get())) {
    double low[3], high[3];
    octomap->getMetricMin(low[0], low[1], low[2]);
    octomap->getMetricMax(high[0], high[1], high[2]);
    o << mrpt::format("Known space: x %.2f to %.2f, y %.2f to %.2f, z %.2f to %.2f m\n", low[0],
                      high[0], low[1], high[1], low[2], high[2]);
  }
}

std::string CObservationLocalMap::exportTxtHeader() const {
  return mrpt::format("%10s %16s %16s %16s %16s %16s %16s  %s", "sequence", "x", "y", "z", "yaw",
                      "pitch", "roll", "map");
}

std::string CObservationLocalMap::exportTxtDataRow() const {
  const auto& p = pose.mean;
  std::string description = map ? map->asString() : "none";
  return mrpt::format("%10llu %16.6f %16.6f %16.6f %16.6f %16.6f %16.6f  \"%s\"",
                      static_cast<unsigned long long>(sequence), p.x(), p.y(), p.z(), p.yaw(),
                      p.pitch(), p.roll(), description.c_str());
}
