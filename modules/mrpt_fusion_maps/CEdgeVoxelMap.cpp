// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * CEdgeVoxelMap: serialization and drawing. */

#include <mrpt/fusion/edges.h>
#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/serialization/CArchive.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <mutex>
#include <utility>
#include <vector>

#include "fusion_base/files.h"
#include "fusion_octree/compression.h"
#include "fusion_octree/files.h"
#include "fusion_octree/resolution.h"
#include "mrpt_fusion_maps/archives/blobs.h"
#include "mrpt_fusion_maps/archives/flags.h"
#include "mrpt_fusion_maps/archives/guarded_archive.h"
#include "mrpt_fusion_maps/archives/packed_nodes.h"
#include "mrpt_fusion_maps/edge_cost.h"

using namespace mrpt::fusion;
using namespace mrpt::maps;

IMPLEMENTS_SERIALIZABLE(CEdgeVoxelMap, CMetricMap, mrpt::maps)

CEdgeVoxelMap::CEdgeVoxelMap(const CProbOctoMap& map, const EdgeParams& params)
    : CEdgeVoxelMap(extractEdges(extractOccupiedVoxels(map.octree()), params)) {}

/** Edge voxels, with covariances from the first use on. */
class CEdgeVoxelMap::Edges {
 public:
  /** \param[in] edges Edge voxels, with covariances or without. */
  explicit Edges(EdgeVoxels edges) : bare_(edges) {
    if (edges.covariance.size() == edges.size())
      std::call_once(computed_, [&] { whole_ = std::move(edges); });
  }

  /** Returns the edge voxels without covariances. */
  static const EdgeVoxels& bare(const std::shared_ptr<const Edges>& edges) {
    return edges ? edges->bare_ : none();
  }
  /** Returns the edge voxels with covariances. */
  static const EdgeVoxels& whole(const std::shared_ptr<const Edges>& edges) {
    if (!edges) return none();
    std::call_once(edges->computed_, [&] { edges->compute(); });
    return edges->whole_;
  }

 private:
  static const EdgeVoxels& none() {
    static const EdgeVoxels none;
    return none;
  }
  void compute() const {
    // While it waits for other threads, this thread must not take a task that waits for the edges.
    tbb::this_task_arena::isolate(
        [&] { whole_ = edgesOf(probabilityTree(bare_), bare_.direction_radius); });
  }

  EdgeVoxels bare_;
  mutable EdgeVoxels whole_;
  mutable std::once_flag computed_;
};

namespace {

/** Largest radius of eq. (6), voxels, see EdgeParams. */
constexpr double kMostRadius = 64;

/** Reads the edge voxels without covariances from an octree of probabilityTree().
 * \exception std::exception If the octree does not hold edge voxels, or the cost is too high. */
EdgeVoxels bareEdgesOf(const octomap::OcTree& tree, double direction_radius) {
  EdgeVoxels edges;
  edges.resolution = tree.getResolution();
  edges.direction_radius = direction_radius;
  std::vector<octomap::OcTreeKey> keys;
  for (auto it = tree.begin_leafs(); it != tree.end_leafs(); ++it) {
    ASSERTMSG_(
        it.getDepth() == tree.getTreeDepth() && it->getLogOdds() > 0 && it->getLogOdds() <= 1,
        "corrupt stream: not edge voxels");
    keys.push_back(it.getKey());
    const octomap::point3d p = tree.keyToCoord(keys.back());
    edges.centre.emplace_back(p.x(), p.y(), p.z());
    edges.probability.push_back(it->getLogOdds());
  }
  const uint64_t pairs =
      edgePairs(keys, std::min(kMostRadius, direction_radius / edges.resolution));
  // Of each map alone: covariances are computed for the maps that are used, not for all updates.
  if (pairs > ReadingBudget::kMostEdgePairs)
    throw ReadingStopped("corrupt stream: the edge voxels are too dense for their radius");
  return edges;
}

}  // namespace

CEdgeVoxelMap::CEdgeVoxelMap(const EdgeVoxels& edges)
    : m_edges(std::make_shared<Edges>(edgesOf(probabilityTree(edges), edges.direction_radius))) {}

const EdgeVoxels& CEdgeVoxelMap::edges() const { return Edges::whole(m_edges); }
size_t CEdgeVoxelMap::size() const { return Edges::bare(m_edges).size(); }
double CEdgeVoxelMap::getResolution() const { return Edges::bare(m_edges).resolution; }
void CEdgeVoxelMap::internal_clear() { m_edges.reset(); }

uint8_t CEdgeVoxelMap::serializeGetVersion() const { return 0; }

void CEdgeVoxelMap::serializeTo(mrpt::serialization::CArchive& out) const {
  const EdgeVoxels& edges = Edges::bare(m_edges);
  out << genericMapParams << edges.resolution << edges.direction_radius;
  writeBlob(out,
            isEmpty() ? std::string() : compressNodes(probabilityTree(edges), Packing::Smallest));
  writeEndMark(out);
}

void CEdgeVoxelMap::serializeFrom(mrpt::serialization::CArchive& in, uint8_t version) {
  if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  CEdgeVoxelMap map;  // this map stays as it was if the stream ends early
  double resolution = 0, direction_radius = 0;
  GuardedArchive guarded(in);
  guarded >> map.genericMapParams >> resolution >> direction_radius;
  checkFlags(map.genericMapParams);
  const std::string nodes = readBlob(guarded);
  readEndMark(guarded);
  if (!nodes.empty()) {
    checkResolution(resolution);
    ASSERTMSG_(direction_radius >= 0 && direction_radius < 100 * resolution,
               "CEdgeVoxelMap: corrupt stream: wrong radius");
    octomap::OcTree tree(resolution);
    unpackNodes(nodes, guarded.budget(), tree);
    map.m_edges = std::make_shared<Edges>(bareEdgesOf(tree, direction_radius));
  }
  *this = std::move(map);
}

octomap::OcTree CEdgeVoxelMap::asOcTree() const { return occupancyTree(Edges::bare(m_edges)); }

std::string CEdgeVoxelMap::asString() const {
  return mrpt::format("Structural edges, %zu voxels of %.03f m", size(), getResolution());
}

void CEdgeVoxelMap::getVisualizationInto(viz::CSetOfObjects& o) const {
  if (!genericMapParams.enableSaveAs3DObject) return;
  auto lines = viz::CSetOfLines::Create();
  lines->setColor_u8(mrpt::img::TColor(220, 50, 30));
  lines->setLineWidth(2);
  lines->setName("edges");
  const EdgeVoxels& edges = this->edges();
  for (size_t i = 0; i < edges.size(); i++) {
    const auto& covariance = edges.covariance[i];
    const double length = edges.resolution * (1 + 3 * covariance.linearity());
    const Eigen::Vector3d centre = edges.centre[i].cast<double>();
    const Eigen::Vector3d half = 0.5 * length * covariance.direction();
    const Eigen::Vector3d from = centre - half, to = centre + half;
    lines->appendLine(from.x(), from.y(), from.z(), to.x(), to.y(), to.z());
  }
  o.insert(lines);
}

void CEdgeVoxelMap::saveMetricMapRepresentationToFile(const std::string& filNamePrefix) const {
  writeFileAtomically(filNamePrefix + ".ply", toPly(edges()));
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
