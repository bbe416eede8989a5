// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * CEdgeVoxelMap: serialization and drawing. */

#include <mrpt/fusion/edge_octree.h>
#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/serialization/CArchive.h>

#include <cmath>

#include "fusion_base/files.h"
#include "fusion_octree/compression.h"
#include "fusion_octree/files.h"
#include "mrpt_fusion_maps/archive_blobs.h"

using namespace mrpt::fusion;
using namespace mrpt::maps;

IMPLEMENTS_SERIALIZABLE(CEdgeVoxelMap, CMetricMap, mrpt::maps)

CEdgeVoxelMap::CEdgeVoxelMap(const CProbOctoMap& map, const EdgeParams& params)
    : CEdgeVoxelMap(extractEdges(extractOccupiedVoxels(map.octree()), params)) {}

CEdgeVoxelMap::CEdgeVoxelMap(const EdgeVoxels& edges)
    : m_edges(edgesOf(probabilityTree(edges), edges.direction_radius)) {}

uint8_t CEdgeVoxelMap::serializeGetVersion() const { return 0; }

void CEdgeVoxelMap::serializeTo(mrpt::serialization::CArchive& out) const {
  out << genericMapParams << m_edges.resolution << m_edges.direction_radius;
  writeBlob(out, isEmpty() ? std::string() : compressNodes(probabilityTree(m_edges)));
  writeEndMark(out);
}

void CEdgeVoxelMap::serializeFrom(mrpt::serialization::CArchive& in, uint8_t version) {
  if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  CEdgeVoxelMap map;  // this map stays as it was if the stream ends early
  double resolution = 0, direction_radius = 0;
  in >> map.genericMapParams >> resolution >> direction_radius;
  const std::string nodes = readBlob(in);
  readEndMark(in);
  if (!nodes.empty()) {
    ASSERTMSG_(resolution > 0 && std::isfinite(resolution) && direction_radius >= 0 &&
                   direction_radius < 100 * resolution,
               "CEdgeVoxelMap: corrupt stream: wrong voxel size or radius");
    octomap::OcTree tree(resolution);
    decompressNodes(nodes, tree);
    map.m_edges = edgesOf(tree, direction_radius);
  }
  *this = std::move(map);
}

octomap::OcTree CEdgeVoxelMap::asOcTree() const { return occupancyTree(m_edges); }

std::string CEdgeVoxelMap::asString() const {
  return mrpt::format("Structural edges, %zu voxels of %.03f m", size(), getResolution());
}

void CEdgeVoxelMap::getVisualizationInto(viz::CSetOfObjects& o) const {
  if (!genericMapParams.enableSaveAs3DObject) return;
  auto lines = viz::CSetOfLines::Create();
  lines->setColor_u8(mrpt::img::TColor(220, 50, 30));
  lines->setLineWidth(2);
  lines->setName("edges");
  for (size_t i = 0; i < size(); i++) {
    const auto& covariance = m_edges.covariance[i];
    const double length = m_edges.resolution * (1 + 3 * covariance.linearity());
    const Eigen::Vector3d centre = m_edges.centre[i].cast<double>();
    const Eigen::Vector3d half = 0.5 * length * covariance.direction();
    const Eigen::Vector3d from = centre - half, to = centre + half;
    lines->appendLine(from.x(), from.y(), from.z(), to.x(), to.y(), to.z());
  }
  o.insert(lines);
}

void CEdgeVoxelMap::saveMetricMapRepresentationToFile(const std::string& filNamePrefix) const {
  writeFileAtomically(filNamePrefix + ".ply", toPly(m_edges));
}

bool CEdgeVoxelMap::internal_insertObservation(const mrpt::obs::CObservation&,
                                               const std::optional<const mrpt::poses::CPose3D>&) {
  return false;
}
double CEdgeVoxelMap::internal_computeObservationLikelihood(const mrpt::obs::CObservation&,
                                                            const mrpt::poses::CPose3D&) const {
  THROW_EXCEPTION("CEdgeVoxelMap: edges have no likelihood of observations");
}
bool CEdgeVoxelMap::internal_canComputeObservationLikelihood(const mrpt::obs::CObservation&) const {
  return false;
}
