// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/maps/archive_blobs.h>
#include <mrpt/maps/octree_compression.h>
#include <mrpt/maps/octree_io.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cmath>
#include <sstream>

using namespace mrpt::maps;
using mrpt::fusion::EdgeVoxels;

IMPLEMENTS_SERIALIZABLE(CEdgeVoxelMap, CMetricMap, mrpt::maps)

namespace {

/** An octree of edge voxels, each with a value made of its probability. */
template <class F>
octomap::OcTree treeOf(const EdgeVoxels& edges, F&& value) {
  ASSERTMSG_(edges.resolution > 0 && std::isfinite(edges.resolution),
             "CEdgeVoxelMap: the resolution must be a positive length");
  octomap::OcTree tree(edges.resolution);
  for (size_t i = 0; i < edges.size(); i++) {
    octomap::OcTreeKey key;
    const Eigen::Vector3f& c = edges.centre[i];
    ASSERTMSG_(c.allFinite() && tree.coordToKeyChecked(c.x(), c.y(), c.z(), key),
               "CEdgeVoxelMap: an edge voxel lies outside the octree's grid");
    const float p = edges.probability[i];
    ASSERTMSG_(p > 0 && p <= 1, "CEdgeVoxelMap: an edge voxel's probability is not in (0,1]");
    tree.setNodeValue(key, 0.F, true)->setLogOdds(value(p));
  }
  tree.updateInnerOccupancy();
  return tree;
}

/** Its nodes hold probabilities, not log-odds: to convert them would cost their last bits. */
octomap::OcTree treeOfProbabilities(const EdgeVoxels& edges) {
  return treeOf(edges, [](float p) { return p; });
}

EdgeVoxels edgesOf(const octomap::OcTree& tree, double direction_radius) {
  std::vector<octomap::OcTreeKey> at;
  std::vector<float> probability;
  for (auto it = tree.begin_leafs(); it != tree.end_leafs(); ++it) {
    ASSERTMSG_(
        it.getDepth() == tree.getTreeDepth() && it->getLogOdds() > 0 && it->getLogOdds() <= 1,
        "CEdgeVoxelMap: corrupt stream: not edge voxels");
    at.push_back(it.getKey());
    probability.push_back(it->getLogOdds());
  }
  return mrpt::fusion::edgeVoxelsAt(at, std::move(probability), tree, direction_radius);
}

}  // namespace

CEdgeVoxelMap::CEdgeVoxelMap(const CProbOctoMap& map, const mrpt::fusion::EdgeParams& params)
    : CEdgeVoxelMap(extractEdges(mrpt::fusion::extractOccupiedVoxels(map.octree()), params)) {}

CEdgeVoxelMap::CEdgeVoxelMap(const EdgeVoxels& edges)
    : m_edges(edgesOf(treeOfProbabilities(edges), edges.direction_radius)) {}

uint8_t CEdgeVoxelMap::serializeGetVersion() const { return 0; }

void CEdgeVoxelMap::serializeTo(mrpt::serialization::CArchive& out) const {
  out << genericMapParams << m_edges.resolution << m_edges.direction_radius;
  writeBlob(out, isEmpty() ? std::string() : compressNodes(treeOfProbabilities(m_edges)));
  writeEndMark(out);
}

void CEdgeVoxelMap::serializeFrom(mrpt::serialization::CArchive& in, uint8_t version) {
  if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  CEdgeVoxelMap map;  // first: what ends early leaves this one as it was
  double resolution = 0, direction_radius = 0;
  in >> map.genericMapParams >> resolution >> direction_radius;
  const std::string nodes = readBlob(in);
  readEndMark(in);
  if (!nodes.empty()) {
    ASSERTMSG_(resolution > 0 && std::isfinite(resolution) && direction_radius >= 0 &&
                   direction_radius < 100 * resolution,
               "CEdgeVoxelMap: corrupt stream: no voxel size or radius");
    octomap::OcTree tree(resolution);
    decompressNodes(nodes, tree);
    map.m_edges = edgesOf(tree, direction_radius);
  }
  *this = std::move(map);
}

octomap::OcTree CEdgeVoxelMap::asOcTree() const {
  constexpr float kMost = 0.999F;  // log-odds of 1 are infinite
  if (isEmpty()) return octomap::OcTree(0.1);
  return treeOf(m_edges, [=](float p) { return octomap::logodds(std::min(p, kMost)); });
}

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
  THROW_EXCEPTION("CEdgeVoxelMap: edges say nothing of how likely an observation is");
}
bool CEdgeVoxelMap::internal_canComputeObservationLikelihood(const mrpt::obs::CObservation&) const {
  return false;
}

std::string mrpt::maps::toPly(const EdgeVoxels& edges) {
  std::ostringstream out;
  out << "ply\nformat ascii 1.0\n"
      << "comment structural edge voxels: nx ny nz is the direction of the edge\n"
      << "element vertex " << edges.size() << "\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "probability", "linearity"})
    out << "property float " << name << "\n";
  out << "end_header\n";
  for (size_t i = 0; i < edges.size(); i++) {
    const Eigen::Vector3d tau = edges.covariance[i].direction();
    out << edges.centre[i].transpose() << " " << tau.transpose() << " " << edges.probability[i]
        << " " << edges.covariance[i].linearity() << "\n";
  }
  return out.str();
}
