// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion_compat.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/maps/error_text.h>
#include <mrpt/maps/octree_build.h>
#include <mrpt/maps/octree_io.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/serialization/CSchemeArchiveBase.h>
#include <mrpt/system/filesystem.h>

#include <algorithm>
#include <cmath>
#include <sstream>

using namespace mrpt::maps;
using namespace mrpt::obs;

IMPLEMENTS_SERIALIZABLE(CProbOctoMap, CMetricMap, mrpt::maps)
MAP_DEFINITION_REGISTER("mrpt::maps::CProbOctoMap,probOctoMap", mrpt::maps::CProbOctoMap)

// ---------------------------------------------------------------- map definition and options

CProbOctoMap::TMapDefinition::TMapDefinition() = default;

void CProbOctoMap::TMapDefinition::loadFromConfigFile_map_specific(
    const mrpt::config::CConfigFileBase& source, const std::string& prefix) {
  MRPT_LOAD_CONFIG_VAR(resolution, double, source, prefix + "_creationOpts");
  insertionOpts.loadFromConfigFile(source, prefix + "_insertOpts");
  likelihoodOpts.loadFromConfigFile(source, prefix + "_likelihoodOpts");
}

void CProbOctoMap::TMapDefinition::dumpToTextStream_map_specific(std::ostream& out) const {
  LOADABLEOPTS_DUMP_VAR(resolution, double);
  insertionOpts.dumpToTextStream(out);
  likelihoodOpts.dumpToTextStream(out);
}

CreatedMap CProbOctoMap::internal_CreateFromMapDefinition(
    const TMetricMapInitializer& initializer) {
  const auto& def = dynamic_cast<const TMapDefinition&>(initializer);
  auto map = std::make_unique<CProbOctoMap>(def.resolution);
  map->insertionOptions = def.insertionOpts;
  map->likelihoodOptions = def.likelihoodOpts;
  map->applySensorModel();
  return createdMap(std::move(map));
}

void CProbOctoMap::TInsertionOptions::loadFromConfigFile(
    const mrpt::config::CConfigFileBase& source, const std::string& section) {
  MRPT_LOAD_CONFIG_VAR(maxrange, double, source, section);
  MRPT_LOAD_CONFIG_VAR(pruning, bool, source, section);
  MRPT_LOAD_CONFIG_VAR(occupancyThres, double, source, section);
  MRPT_LOAD_CONFIG_VAR(probHit, double, source, section);
  MRPT_LOAD_CONFIG_VAR(probMiss, double, source, section);
  MRPT_LOAD_CONFIG_VAR(clampingThresMin, double, source, section);
  MRPT_LOAD_CONFIG_VAR(clampingThresMax, double, source, section);
}

void CProbOctoMap::TInsertionOptions::saveToConfigFile(mrpt::config::CConfigFileBase& c,
                                                       const std::string& s) const {
  MRPT_SAVE_CONFIG_VAR_COMMENT(maxrange, "Length to which beams are inserted, m (-1: all of it)");
  MRPT_SAVE_CONFIG_VAR_COMMENT(pruning, "Prune the tree, without loss, after each insertion");
  MRPT_SAVE_CONFIG_VAR_COMMENT(occupancyThres, "Probability from which a voxel is occupied");
  MRPT_SAVE_CONFIG_VAR_COMMENT(probHit, "Probability that a voxel with a hit is occupied");
  MRPT_SAVE_CONFIG_VAR_COMMENT(probMiss, "Probability that a voxel crossed by a beam is occupied");
  MRPT_SAVE_CONFIG_VAR_COMMENT(clampingThresMin, "Lowest probability that a voxel can reach");
  MRPT_SAVE_CONFIG_VAR_COMMENT(clampingThresMax, "Highest probability that a voxel can reach");
}

void CProbOctoMap::TInsertionOptions::check() const {
  for (const double p : {occupancyThres, probHit, probMiss, clampingThresMin, clampingThresMax})
    ASSERTMSG_(p > 0 && p < 1,
               "CProbOctoMap: a probability in the insertion options is not in (0,1)");
  ASSERTMSG_(probHit >= 0.5 && probMiss <= 0.5,
             "CProbOctoMap: probHit must be at least 0.5 and probMiss at most 0.5");
  ASSERTMSG_(clampingThresMin < clampingThresMax,
             "CProbOctoMap: clampingThresMin must be below clampingThresMax");
}

// ---------------------------------------------------------------- construction

CProbOctoMap::CProbOctoMap(double resolution) {
  ASSERTMSG_(resolution > 0 && std::isfinite(resolution),
             "CProbOctoMap: the resolution must be a positive length");
  m_octree = std::make_unique<octomap::OcTree>(resolution);
  applySensorModel();
}

CProbOctoMap::CProbOctoMap(std::unique_ptr<octomap::OcTree> tree) { setOctree(std::move(tree)); }

CProbOctoMap::CProbOctoMap(const COctoMap& o) : CProbOctoMap(o.getResolution()) { fromOctoMap(o); }

CProbOctoMap::CProbOctoMap(const CProbOctoMap& o)
    : CMetricMap(o),
      insertionOptions(o.insertionOptions),
      likelihoodOptions(o.likelihoodOptions),
      renderingOptions(o.renderingOptions),
      m_octree(std::make_unique<octomap::OcTree>(*o.m_octree)) {}

CProbOctoMap& CProbOctoMap::operator=(const CProbOctoMap& o) {
  CProbOctoMap copy(o);
  *this = std::move(copy);
  return *this;
}

CProbOctoMap::~CProbOctoMap() = default;

void CProbOctoMap::setOctree(std::unique_ptr<octomap::OcTree> tree) {
  ASSERTMSG_(tree, "CProbOctoMap::setOctree(): no tree");
  m_octree = std::move(tree);
  insertionOptions.occupancyThres = m_octree->getOccupancyThres();
  insertionOptions.probHit = m_octree->getProbHit();
  insertionOptions.probMiss = m_octree->getProbMiss();
  insertionOptions.clampingThresMin = m_octree->getClampingThresMin();
  insertionOptions.clampingThresMax = m_octree->getClampingThresMax();
}

void CProbOctoMap::applySensorModel() {
  insertionOptions.check();
  m_octree->setOccupancyThres(insertionOptions.occupancyThres);
  m_octree->setProbHit(insertionOptions.probHit);
  m_octree->setProbMiss(insertionOptions.probMiss);
  m_octree->setClampingThresMin(insertionOptions.clampingThresMin);
  m_octree->setClampingThresMax(insertionOptions.clampingThresMax);
}

void CProbOctoMap::internal_clear() { m_octree->clear(); }

std::string CProbOctoMap::asString() const {
  return mrpt::format("Probabilistic octomap, voxels of %.03f m, %zu nodes", getResolution(),
                      size());
}

// ---------------------------------------------------------------- serialization

/** Ends a serialized map: MRPT takes part of a number for all of it where a stream ends early. */
constexpr uint32_t kEndMark = 0x50524f42;

uint8_t CProbOctoMap::serializeGetVersion() const { return 0; }

void CProbOctoMap::serializeTo(mrpt::serialization::CArchive& out) const {
  out << genericMapParams;
  likelihoodOptions.writeToStream(out);
  renderingOptions.writeToStream(out);
  const auto& i = insertionOptions;
  out << i.maxrange << i.pruning << i.occupancyThres << i.probHit << i.probMiss
      << i.clampingThresMin << i.clampingThresMax;
  const auto m = OcTreeAccess::sensorModel(*m_octree);
  out << m_octree->getResolution() << m.clamp_min << m.clamp_max << m.hit << m.miss
      << m.occupancy_threshold;
  const std::string nodes = serializeNodes(*m_octree);
  out << static_cast<uint64_t>(nodes.size());
  if (!nodes.empty()) out.WriteBuffer(nodes.data(), nodes.size());
  out << kEndMark;
}

namespace {
/** Reads \a size bytes in blocks: a length field that lies runs into the end of the stream before
 * it has taken much memory. */
std::string readBlob(mrpt::serialization::CArchive& in, uint64_t size) {
  constexpr uint64_t kBlock = 1 << 20;
  std::string bytes;
  while (bytes.size() < size) {
    const auto n = static_cast<size_t>(std::min(kBlock, size - bytes.size()));
    bytes.resize(bytes.size() + n);
    if (in.ReadBuffer(&bytes[bytes.size() - n], n) != n)
      THROW_EXCEPTION("CProbOctoMap: corrupt stream: it ends early");
  }
  return bytes;
}
}  // namespace

void CProbOctoMap::serializeFrom(mrpt::serialization::CArchive& in, uint8_t version) {
  if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  // Into a map of its own first: a stream that ends early leaves this one as it was.
  CProbOctoMap map;
  in >> map.genericMapParams;
  map.likelihoodOptions.readFromStream(in);
  map.renderingOptions.readFromStream(in);
  auto& i = map.insertionOptions;
  in >> i.maxrange >> i.pruning >> i.occupancyThres >> i.probHit >> i.probMiss >>
      i.clampingThresMin >> i.clampingThresMax;
  double resolution = 0;
  OcTreeAccess::SensorModel m{};
  uint64_t size = 0;
  in >> resolution >> m.clamp_min >> m.clamp_max >> m.hit >> m.miss >> m.occupancy_threshold >>
      size;
  ASSERTMSG_(resolution > 0 && std::isfinite(resolution),
             "CProbOctoMap: corrupt stream: the resolution is not a positive length");
  map.m_octree = std::make_unique<octomap::OcTree>(resolution);
  OcTreeAccess::setSensorModel(*map.m_octree, m);
  const std::string nodes = readBlob(in, size);
  uint32_t end_mark = 0;
  in >> end_mark;
  ASSERTMSG_(end_mark == kEndMark, "CProbOctoMap: corrupt stream: it ends early");
  parseNodes(nodes, *map.m_octree);
  *this = std::move(map);
}

// ---------------------------------------------------------------- observations

namespace {

/** The points of an observation in the map's frame and where the sensor was. */
struct Rays {
  octomap::point3d origin;
  octomap::Pointcloud ends;
};

template <class Point>
void addPoint(const mrpt::poses::CPose3D& frame, const Point& p, Rays& rays) {
  double x, y, z;
  frame.composePoint(p.x, p.y, p.z, x, y, z);
  if (std::isfinite(x) && std::isfinite(y) && std::isfinite(z))
    rays.ends.push_back(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
}

void addPoints(const mrpt::poses::CPose3D& frame, const CPointsMap& points, Rays& rays) {
  rays.ends.reserve(points.size());
  for (size_t i = 0; i < points.size(); i++) {
    mrpt::math::TPoint3Df p;
    points.getPointFast(i, p.x, p.y, p.z);
    addPoint(frame, p, rays);
  }
}

/** \return Nothing if the observation is not of a kind that an octomap takes, or has no points. */
std::optional<Rays> raysOf(const CObservation& obs, const mrpt::poses::CPose3D& robot) {
  obs.load();  // lazy-loaded observations
  mrpt::poses::CPose3D sensor_on_robot;
  obs.getSensorPose(sensor_on_robot);
  const mrpt::poses::CPose3D sensor = robot + sensor_on_robot;
  Rays rays;
  rays.origin = octomap::point3d(static_cast<float>(sensor.x()), static_cast<float>(sensor.y()),
                                 static_cast<float>(sensor.z()));

  if (const auto* scan2d = dynamic_cast<const CObservation2DRangeScan*>(&obs)) {
    // MRPT gives these points in the robot's frame.
    addPoints(robot, *scan2d->buildAuxPointsMap<CPointsMap>(), rays);
  } else if (const auto* scan3d = dynamic_cast<const CObservation3DRangeScan*>(&obs)) {
    if (scan3d->hasPoints3D) {
      const size_t n = scan3d->points3D_x.size();
      rays.ends.reserve(n);
      for (size_t i = 0; i < n; i++) {
        const mrpt::math::TPoint3Df p(scan3d->points3D_x[i], scan3d->points3D_y[i],
                                      scan3d->points3D_z[i]);
        if (p.x != 0 || p.y != 0 || p.z != 0) addPoint(sensor, p, rays);  // (0,0,0): no return
      }
    } else if (scan3d->hasRangeImage) {
      CObservation3DRangeScan copy(*scan3d);  // unprojectInto() is not const
      CSimplePointsMap points;
      copy.unprojectInto(points);
      addPoints(sensor, points, rays);
    } else {
      return std::nullopt;
    }
  } else if (const auto* velodyne = dynamic_cast<const CObservationVelodyneScan*>(&obs)) {
    const auto add = [&](const CObservationVelodyneScan::TPointCloud& cloud) {
      rays.ends.reserve(cloud.x.size());
      for (size_t i = 0; i < cloud.x.size(); i++)
        addPoint(sensor, mrpt::math::TPoint3Df(cloud.x[i], cloud.y[i], cloud.z[i]), rays);
    };
    if (velodyne->point_cloud.x.empty()) {
      CObservationVelodyneScan copy(*velodyne);  // generatePointCloud() is not const
      copy.generatePointCloud();
      add(copy.point_cloud);
    } else {
      add(velodyne->point_cloud);
    }
  } else if (const auto* cloud = dynamic_cast<const CObservationPointCloud*>(&obs)) {
    if (!cloud->pointcloud) return std::nullopt;
    addPoints(sensor, *cloud->pointcloud, rays);
  } else {
    return std::nullopt;
  }
  return rays;
}

}  // namespace

bool CProbOctoMap::internal_insertObservation(
    const CObservation& obs, const std::optional<const mrpt::poses::CPose3D>& robotPose) {
  const auto rays = raysOf(obs, robotPose.value_or(mrpt::poses::CPose3D()));
  if (!rays) return false;
  applySensorModel();
  // Lazily, then the inner nodes once: a fraction of the cost of updating them ray by ray.
  m_octree->insertPointCloud(rays->ends, rays->origin, insertionOptions.maxrange, true);
  m_octree->updateInnerOccupancy();
  if (insertionOptions.pruning) m_octree->prune();
  return true;
}

void CProbOctoMap::insertPointCloud(const CPointsMap& points, float sensor_x, float sensor_y,
                                    float sensor_z) {
  Rays rays;
  addPoints(mrpt::poses::CPose3D(), points, rays);
  applySensorModel();
  m_octree->insertPointCloud(rays.ends, octomap::point3d(sensor_x, sensor_y, sensor_z),
                             insertionOptions.maxrange, true);
  m_octree->updateInnerOccupancy();
  if (insertionOptions.pruning) m_octree->prune();
}

bool CProbOctoMap::internal_canComputeObservationLikelihood(const CObservation& obs) const {
  return IS_DERIVED(obs, CObservation2DRangeScan) || IS_DERIVED(obs, CObservation3DRangeScan) ||
         IS_DERIVED(obs, CObservationVelodyneScan) || IS_DERIVED(obs, CObservationPointCloud);
}

double CProbOctoMap::internal_computeObservationLikelihood(
    const CObservation& obs, const mrpt::poses::CPose3D& takenFrom) const {
  const auto rays = raysOf(obs, takenFrom);
  if (!rays) return 0;
  const size_t step = std::max<size_t>(1, likelihoodOptions.decimation);
  double log_likelihood = 0;
  octomap::OcTreeKey key;
  for (size_t i = 0; i < rays->ends.size(); i += step)
    if (m_octree->coordToKeyChecked(rays->ends.getPoint(static_cast<unsigned>(i)), key))
      if (const auto* node = m_octree->search(key))
        log_likelihood += std::log(node->getOccupancy());
  return log_likelihood;
}

void CProbOctoMap::updateVoxel(double x, double y, double z, bool occupied) {
  applySensorModel();
  m_octree->updateNode(x, y, z, occupied);
}

bool CProbOctoMap::getPointOccupancy(float x, float y, float z, double& prob_occupancy) const {
  octomap::OcTreeKey key;
  if (!m_octree->coordToKeyChecked(octomap::point3d(x, y, z), key)) return false;
  const auto* node = m_octree->search(key);
  if (!node) return false;
  prob_occupancy = node->getOccupancy();
  return true;
}

bool CProbOctoMap::castRay(const mrpt::math::TPoint3D& origin,
                           const mrpt::math::TPoint3D& direction, mrpt::math::TPoint3D& end,
                           bool ignoreUnknownCells, double maxRange) const {
  const auto toOctomap = [](const mrpt::math::TPoint3D& p) {
    return octomap::point3d(static_cast<float>(p.x), static_cast<float>(p.y),
                            static_cast<float>(p.z));
  };
  octomap::point3d hit;
  const bool found =
      m_octree->castRay(toOctomap(origin), toOctomap(direction), hit, ignoreUnknownCells, maxRange);
  end = {hit.x(), hit.y(), hit.z()};
  return found;
}

// ---------------------------------------------------------------- conversion

namespace {

double probability(float log_odds) {
  return 1.0 / (1.0 + std::exp(-static_cast<double>(log_odds)));
}

/** Log-odds as far as double-valued probabilities reach: beyond, they are 0 or 1. */
constexpr float kMaxLogOdds = 36.0F;

/** The probability that OctoMap turns into exactly these log-odds, or as near as doubles allow. */
double exactProbability(float log_odds) {
  ASSERTMSG_(std::abs(log_odds) <= kMaxLogOdds,
             "CProbOctoMap: log-odds too large for a probability in MRPT's COctoMap");
  const double p = probability(log_odds);
  for (const double candidate : {p, std::nextafter(p, 0.0), std::nextafter(p, 1.0)})
    if (octomap::logodds(candidate) == log_odds) return candidate;
  return p;
}

void copySensorModel(const COctoMap& from, octomap::OcTree& to) {
  OcTreeAccess::setSensorModel(
      to, {from.getClampingThresMinLog(), from.getClampingThresMaxLog(), from.getProbHitLog(),
           from.getProbMissLog(), from.getOccupancyThresLog()});
}

/** A leaf cube and its value, ordered by the cube's place in the tree. */
struct LeafCube {
  OcTreeCube cube;
  float log_odds;
};

/** Builds a tree from leaf cubes that are grouped by child at each level on the way down. */
class LeafListVisitor {
 public:
  struct State {
    std::vector<LeafCube> leaves;
  };
  OcTreeFill visit(const OcTreeCube& cube, const State& s) const {
    if (s.leaves.empty()) return OcTreeFill::unknown();
    if (s.leaves.front().cube.depth == cube.depth)
      return OcTreeFill::leaf(s.leaves.front().log_odds);
    return OcTreeFill::split();
  }
  State descend(State& parent, unsigned, const OcTreeCube& child) const {
    State s;
    const auto inChild = [&](const LeafCube& l) {
      for (unsigned axis = 0; axis < 3; axis++) {
        const uint32_t k = l.cube.key[axis], k0 = child.key[axis];
        if (k < k0 || k - k0 >= child.side()) return false;
      }
      return true;
    };
    const auto rest = std::partition(parent.leaves.begin(), parent.leaves.end(),
                                     [&](const LeafCube& l) { return !inChild(l); });
    s.leaves.assign(rest, parent.leaves.end());
    parent.leaves.erase(rest, parent.leaves.end());
    return s;
  }
};

}  // namespace

void CProbOctoMap::fromOctoMap(const COctoMap& o) {
  // Its leaf cubes come out through the drawing API, as its renderingOptions allow.
  viz::COctoMapVoxels voxels;
  const auto& drawn = o.renderingOptions;
  if (drawn.generateOccupiedVoxels && drawn.generateFreeVoxels) {
    o.getAsOctoMapVoxels(voxels);
  } else {
    COctoMap copy(o);
    copy.renderingOptions = TRenderingOptions();
    copy.getAsOctoMapVoxels(voxels);
  }

  auto tree = std::make_unique<octomap::OcTree>(o.getResolution());
  copySensorModel(o, *tree);
  LeafListVisitor::State leaves;
  for (const size_t set : {viz::VOXEL_SET_OCCUPIED, viz::VOXEL_SET_FREESPACE})
    for (size_t i = 0; i < voxels.getVoxelCount(set); i++) {
      const auto& v = voxels.getVoxel(set, i);
      const double levels = std::log2(v.side_length / o.getResolution());
      const auto depth = static_cast<unsigned>(OcTreeCube::kMaxDepth - std::lround(levels));
      double p = 0;
      OcTreeCube cube{{0, 0, 0}, depth};
      const bool known =
          depth <= OcTreeCube::kMaxDepth &&
          o.getPointOccupancy(v.coords.x, v.coords.y, v.coords.z, p) &&
          tree->coordToKeyChecked(v.coords.x, v.coords.y, v.coords.z, depth, cube.key);
      ASSERTMSG_(known, "CProbOctoMap: a voxel of the COctoMap does not lie on an octree's grid");
      const uint32_t lowest = ~(cube.side() - 1U);
      for (unsigned axis = 0; axis < 3; axis++)
        cube.key[axis] = static_cast<octomap::key_type>(cube.key[axis] & lowest);
      // MRPT rounds the probability of a saturated voxel to 0 or 1.
      constexpr double kTiny = 1e-16;
      leaves.leaves.push_back({cube, octomap::logodds(std::clamp(p, kTiny, 1 - kTiny))});
    }
  LeafListVisitor visitor;
  buildOcTree(*tree, std::move(leaves), visitor);

  genericMapParams = o.genericMapParams;
  likelihoodOptions = o.likelihoodOptions;
  renderingOptions = o.renderingOptions;
  insertionOptions.maxrange = o.insertionOptions.maxrange;
  insertionOptions.pruning = o.insertionOptions.pruning;
  setOctree(std::move(tree));
}

void CProbOctoMap::toOctoMap(COctoMap& o) const {
  COctoMap result(getResolution());
  // One "hit" or "miss" of just the wanted strength on each voxel, with nothing clamped.
  constexpr double kTiny = 1e-16;
  result.setClampingThresMin(kTiny);
  result.setClampingThresMax(1 - kTiny);
  for (auto it = m_octree->begin_leafs(); it != m_octree->end_leafs(); ++it) {
    const float log_odds = it->getLogOdds();
    const bool hit = log_odds >= 0;
    if (hit)
      result.setProbHit(exactProbability(log_odds));
    else
      result.setProbMiss(exactProbability(log_odds));
    const octomap::OcTreeKey lowest = it.getIndexKey();
    const uint32_t side = 1U << (OcTreeCube::kMaxDepth - it.getDepth());
    for (uint32_t x = 0; x < side; x++)
      for (uint32_t y = 0; y < side; y++)
        for (uint32_t z = 0; z < side; z++)
          result.updateVoxel(m_octree->keyToCoord(static_cast<octomap::key_type>(lowest[0] + x)),
                             m_octree->keyToCoord(static_cast<octomap::key_type>(lowest[1] + y)),
                             m_octree->keyToCoord(static_cast<octomap::key_type>(lowest[2] + z)),
                             hit);
  }
  result.setOccupancyThres(m_octree->getOccupancyThres());
  result.setProbHit(m_octree->getProbHit());
  result.setProbMiss(m_octree->getProbMiss());
  result.setClampingThresMin(m_octree->getClampingThresMin());
  result.setClampingThresMax(m_octree->getClampingThresMax());
  result.genericMapParams = genericMapParams;
  result.likelihoodOptions = likelihoodOptions;
  result.renderingOptions = renderingOptions;
  result.insertionOptions.maxrange = insertionOptions.maxrange;
  result.insertionOptions.pruning = insertionOptions.pruning;
  o = result;
}

// ---------------------------------------------------------------- files and drawing

void CProbOctoMap::loadFromOcTreeFile(const std::string& path) {
  withPath(path, [&] { setOctree(parseOcTreeFile(readFileBytes(path))); });
}

void CProbOctoMap::saveToOcTreeFile(const std::string& path) const {
  const bool binary = mrpt::system::extractFileExtension(path) == "bt";
  writeFileAtomically(path, binary ? toBtFile(*m_octree) : toOtFile(*m_octree));
}

void CProbOctoMap::saveMetricMapRepresentationToFile(const std::string& filNamePrefix) const {
  Scene scene;
  auto objects = viz::CSetOfObjects::Create();
  getVisualizationInto(*objects);
  scene.insert(objects);
  const std::string path = filNamePrefix + "_3D.3Dscene";
  if (!scene.saveToFile(path)) throw std::runtime_error(path + ": cannot be written");
  saveToOcTreeFile(filNamePrefix + ".ot");
}

void CProbOctoMap::getVisualizationInto(viz::CSetOfObjects& o) const {
  if (!genericMapParams.enableSaveAs3DObject) return;
  auto voxels = viz::COctoMapVoxels::Create();
  getAsOctoMapVoxels(*voxels);
  o.insert(voxels);
}

void CProbOctoMap::getAsOctoMapVoxels(viz::COctoMapVoxels& gl) const {
  using viz::COctoMapVoxels;
  double x_min, y_min, z_min, x_max, y_max, z_max;
  getMetricMin(x_min, y_min, z_min);
  getMetricMax(x_max, y_max, z_max);
  const double height = z_max - z_min + 0.01;
  const mrpt::img::TColorf base = gl.getColor();

  // Brightness and opacity in [0,1] by the object's colouring scheme.
  const auto colour = [&](double z, double occupancy) {
    const double by_height = (z - z_min) / height;
    const double by_occupancy = (240 * (1 - occupancy) + 15) / 255;
    const double opacity = std::max(0.0, 1 - 2 * (1 - occupancy));
    double brightness = 1, alpha = base.A;
    switch (gl.getVisualizationMode()) {
      case COctoMapVoxels::FIXED:
        break;
      case COctoMapVoxels::COLOR_FROM_HEIGHT:
        brightness = by_height;
        break;
      case COctoMapVoxels::COLOR_FROM_OCCUPANCY:
        brightness = by_occupancy;
        break;
      case COctoMapVoxels::TRANSPARENCY_FROM_OCCUPANCY:
        alpha = opacity;
        break;
      case COctoMapVoxels::TRANS_AND_COLOR_FROM_OCCUPANCY:
        brightness = by_occupancy;
        alpha = 50.0 / 255;
        break;
      case COctoMapVoxels::MIXED:
        brightness = by_height;
        alpha = opacity;
        break;
      default:
        THROW_EXCEPTION("Unknown colouring scheme of COctoMapVoxels");
    }
    const auto byte = [](double v) { return static_cast<uint8_t>(255 * v); };
    return mrpt::img::TColor(byte(brightness * base.R), byte(brightness * base.G),
                             byte(brightness * base.B), byte(alpha));
  };

  gl.clear();
  gl.resizeVoxelSets(2);
  gl.showVoxels(viz::VOXEL_SET_OCCUPIED, renderingOptions.visibleOccupiedVoxels);
  gl.showVoxels(viz::VOXEL_SET_FREESPACE, renderingOptions.visibleFreeVoxels);
  for (auto it = m_octree->begin_tree(); it != m_octree->end_tree(); ++it) {
    const mrpt::math::TPoint3D centre(it.getX(), it.getY(), it.getZ());
    if (it.isLeaf()) {
      const bool occupied = m_octree->isNodeOccupied(*it);
      if (occupied ? renderingOptions.generateOccupiedVoxels : renderingOptions.generateFreeVoxels)
        gl.push_back_Voxel(occupied ? viz::VOXEL_SET_OCCUPIED : viz::VOXEL_SET_FREESPACE,
                           COctoMapVoxels::TVoxel(centre.cast<float>(), it.getSize(),
                                                  colour(centre.z, it->getOccupancy())));
    } else if (renderingOptions.generateGridLines) {
      const double half = 0.5 * it.getSize();
      const mrpt::math::TPoint3D corner(half, half, half);
      gl.push_back_GridCube(COctoMapVoxels::TGridCube((centre - corner).cast<float>(),
                                                      (centre + corner).cast<float>()));
    }
  }
  if (gl.isCubeTransparencyEnabled()) gl.sort_voxels_by_z();
  gl.setBoundingBox({x_min, y_min, z_min}, {x_max, y_max, z_max});
}
