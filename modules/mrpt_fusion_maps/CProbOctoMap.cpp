// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/compat.h>
#include <mrpt/fusion/map_files.h>
#include <mrpt/fusion/voxels.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/serialization/CSchemeArchiveBase.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <vector>

#include "fusion_base/config_check.h"
#include "fusion_base/error_text.h"
#include "fusion_base/files.h"
#include "fusion_octree/build.h"
#include "fusion_octree/files.h"
#include "mrpt_fusion_maps/archive_blobs.h"

using namespace mrpt::fusion;
using namespace mrpt::maps;
using namespace mrpt::obs;

IMPLEMENTS_SERIALIZABLE(CProbOctoMap, CMetricMap, mrpt::maps)
MAP_DEFINITION_REGISTER("mrpt::maps::CProbOctoMap,probOctoMap", mrpt::maps::CProbOctoMap)

// ---------------------------------------------------------------- map definition and options

/** Lengths that a map definition may ask for, m. */
constexpr double kFinest = 1e-4, kLongest = 1e6;

CProbOctoMap::TMapDefinition::TMapDefinition() = default;

void CProbOctoMap::TMapDefinition::loadFromConfigFile_map_specific(
    const mrpt::config::CConfigFileBase& source, const std::string& prefix) {
  const std::string creation = prefix + "_creationOpts", likelihood = prefix + "_likelihoodOpts";
  // MRPT has read the generic ones.
  checkKeys(source, creation,
            {"resolution", "enableSaveAs3DObject", "enableObservationLikelihood",
             "enableObservationInsertion"});
  resolution = readNumber(source, creation, "resolution", resolution, kFinest, kLongest);
  insertionOpts.loadFromConfigFile(source, prefix + "_insertOpts");
  checkKeys(source, likelihood, {"decimation"});
  likelihoodOpts.decimation = static_cast<uint32_t>(readNumber(
      source, likelihood, "decimation", likelihoodOpts.decimation, 1, 1e9, NumberKind::Whole));
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

namespace {

/** The insertion options that are probabilities; what is listed here is loaded, checked and saved.
 */
struct ProbabilityOption {
  const char* key;
  double CProbOctoMap::TInsertionOptions::*field;
  const char* comment;
};
constexpr ProbabilityOption kProbabilities[] = {
    {"occupancyThres", &CProbOctoMap::TInsertionOptions::occupancyThres,
     "Probability from which a voxel is occupied"},
    {"probHit", &CProbOctoMap::TInsertionOptions::probHit,
     "Probability that a voxel with a hit is occupied"},
    {"probMiss", &CProbOctoMap::TInsertionOptions::probMiss,
     "Probability that a voxel crossed by a beam is occupied"},
    {"clampingThresMin", &CProbOctoMap::TInsertionOptions::clampingThresMin,
     "Lowest probability that a voxel can reach"},
    {"clampingThresMax", &CProbOctoMap::TInsertionOptions::clampingThresMax,
     "Highest probability that a voxel can reach"}};

}  // namespace

void CProbOctoMap::TInsertionOptions::loadFromConfigFile(
    const mrpt::config::CConfigFileBase& source, const std::string& section) {
  std::vector<std::string> keys = {"maxrange", "pruning"};
  for (const auto& option : kProbabilities) keys.emplace_back(option.key);
  checkKeys(source, section, keys);

  TInsertionOptions loaded(*this);
  loaded.maxrange = readNumber(source, section, "maxrange", maxrange, -1, kLongest);
  loaded.pruning = readFlag(source, section, "pruning", pruning);
  for (const auto& option : kProbabilities)
    loaded.*option.field = readNumber(source, section, option.key, loaded.*option.field, 0, 1);
  try {
    loaded.check();
  } catch (const std::exception& e) {
    THROW_EXCEPTION("[" + section + "] " + messageOf(e));
  }
  *this = loaded;
}

void CProbOctoMap::TInsertionOptions::saveToConfigFile(mrpt::config::CConfigFileBase& c,
                                                       const std::string& s) const {
  MRPT_SAVE_CONFIG_VAR_COMMENT(maxrange, "Length to which beams are inserted, m (-1: all of it)");
  MRPT_SAVE_CONFIG_VAR_COMMENT(pruning, "Prune the tree, without loss, after each insertion");
  for (const auto& option : kProbabilities)
    c.write(s, option.key, this->*option.field, -1, -1, option.comment);
}

void CProbOctoMap::TInsertionOptions::check() const {
  ASSERTMSG_(maxrange > 0 || maxrange == -1,
             mrpt::format("CProbOctoMap: maxrange = %g is neither -1 nor a length", maxrange));
  for (const auto& option : kProbabilities) {
    const double p = this->*option.field;
    ASSERTMSG_(p > 0 && p < 1,
               mrpt::format("CProbOctoMap: %s = %g is not in (0,1)", option.key, p));
  }
  ASSERTMSG_(probHit >= 0.5 && probMiss <= 0.5,
             mrpt::format("CProbOctoMap: probHit = %g must be at least 0.5 and probMiss = %g at "
                          "most 0.5",
                          probHit, probMiss));
  ASSERTMSG_(clampingThresMin < clampingThresMax,
             mrpt::format("CProbOctoMap: clampingThresMin = %g must be below clampingThresMax = %g",
                          clampingThresMin, clampingThresMax));
}

// ---------------------------------------------------------------- construction

CProbOctoMap::CProbOctoMap(double resolution) {
  ASSERTMSG_(resolution > 0 && std::isfinite(resolution),
             "CProbOctoMap: the resolution must be a positive length");
  m_octree = std::make_unique<octomap::OcTree>(resolution);
  applySensorModel();
}

CProbOctoMap::CProbOctoMap(std::unique_ptr<octomap::OcTree> tree) { setOctree(std::move(tree)); }

CProbOctoMap::CProbOctoMap(const octomap::OcTree& tree)
    : CProbOctoMap(std::make_unique<octomap::OcTree>(tree)) {}

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
  writeBlob(out, serializeNodes(*m_octree));
  writeEndMark(out);
}

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
  in >> resolution >> m.clamp_min >> m.clamp_max >> m.hit >> m.miss >> m.occupancy_threshold;
  ASSERTMSG_(resolution > 0 && std::isfinite(resolution),
             "CProbOctoMap: corrupt stream: the resolution is not a positive length");
  map.m_octree = std::make_unique<octomap::OcTree>(resolution);
  OcTreeAccess::setSensorModel(*map.m_octree, m);
  const std::string nodes = readBlob(in);
  readEndMark(in);
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
  double x = 0, y = 0, z = 0;
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

void CProbOctoMap::finishInsertion() {
  m_octree->updateInnerOccupancy();
  if (insertionOptions.pruning) m_octree->prune();
}

bool CProbOctoMap::internal_insertObservation(
    const CObservation& obs, const std::optional<const mrpt::poses::CPose3D>& robotPose) {
  const auto rays = raysOf(obs, robotPose.value_or(mrpt::poses::CPose3D()));
  if (!rays) return false;
  applySensorModel();
  m_octree->insertPointCloud(rays->ends, rays->origin, insertionOptions.maxrange, true);
  finishInsertion();
  return true;
}

void CProbOctoMap::insertPointCloud(const CPointsMap& points, float sensor_x, float sensor_y,
                                    float sensor_z) {
  Rays rays;
  addPoints(mrpt::poses::CPose3D(), points, rays);
  applySensorModel();
  m_octree->insertPointCloud(rays.ends, octomap::point3d(sensor_x, sensor_y, sensor_z),
                             insertionOptions.maxrange, true);
  finishInsertion();
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

void CProbOctoMap::insertPointCloud(const CPointsMap& points) {
  Rays rays;
  addPoints(mrpt::poses::CPose3D(), points, rays);
  applySensorModel();
  for (const auto& p : rays.ends) m_octree->updateNode(p, true, true);
  finishInsertion();
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

// ---------------------------------------------------------------- points and matching

namespace {

/** The centres of a map's occupied voxels, in the order of the octree. */
std::shared_ptr<CSimplePointsMap> occupiedPoints(const octomap::OcTree& tree) {
  auto points = std::make_shared<CSimplePointsMap>();
  const mrpt::fusion::OccupiedVoxels voxels = mrpt::fusion::extractOccupiedVoxels(tree);
  points->reserve(voxels.size());
  for (const auto& p : voxels.centre) points->insertPointFast(p.x(), p.y(), p.z());
  points->mark_as_modified();  // insertPointFast() leaves that to its caller
  return points;
}

bool samePoints(const CPointsMap& a, const CPointsMap& b) {
  return a.getPointsBufferRef_x() == b.getPointsBufferRef_x() &&
         a.getPointsBufferRef_y() == b.getPointsBufferRef_y() &&
         a.getPointsBufferRef_z() == b.getPointsBufferRef_z();
}

/** The points of the other map of a matching. */
std::shared_ptr<const CPointsMap> pointsOf(const CMetricMap* map) {
  ASSERTMSG_(map, "CProbOctoMap: there is no map to match with");
  if (const auto* points = dynamic_cast<const CPointsMap*>(map))
    return {std::shared_ptr<const CPointsMap>(), points};  // not owned
  if (const CPointsMap* points = map->getAsSimplePointsMap())
    return {std::shared_ptr<const CPointsMap>(), points};
  const auto octomap = asProbOctoMap(*map);
  ASSERTMSG_(octomap, std::string("CProbOctoMap: a ") + map->GetRuntimeClass()->className +
                          " has no points to match with");
  return occupiedPoints(octomap->octree());
}

/** Branch and bound on the square distance, in the plane, to the centres of occupied voxels. */
class ClosestInPlane {
 public:
  ClosestInPlane(const octomap::OcTree& tree, double x, double y) : tree_(tree), xy_{x, y} {
    if (tree.getRoot()) descend(*tree.getRoot(), {});
  }
  /** m^2; infinite if no voxel is occupied. */
  double squareDistance() const { return best_; }

 private:
  /** To the closest centre of a cube's voxels. */
  double squareDistanceTo(const OcTreeCube& cube) const {
    double sum = 0;
    for (unsigned axis = 0; axis < 2; axis++) {
      const auto centre = [&](uint32_t k) {
        return tree_.keyToCoord(static_cast<octomap::key_type>(k));
      };
      const double first = centre(cube.key[axis]), last = centre(cube.key[axis] + cube.side() - 1);
      const double steps = std::round((xy_[axis] - first) / tree_.getResolution());
      const double closest = std::clamp(first + steps * tree_.getResolution(), first, last);
      sum += (xy_[axis] - closest) * (xy_[axis] - closest);
    }
    return sum;
  }

  void descend(const octomap::OcTreeNode& node, const OcTreeCube& cube) {
    if (squareDistanceTo(cube) >= best_) return;
    if (!tree_.nodeHasChildren(&node)) {
      if (tree_.isNodeOccupied(node)) best_ = squareDistanceTo(cube);
      return;
    }
    // The child on the point's side first, so that the bound is soon a tight one.
    const auto middle = cube.child(7).key;
    unsigned near = 0;
    for (unsigned axis = 0; axis < 2; axis++)
      if (xy_[axis] > tree_.keyToCoord(middle[axis]) - 0.5 * tree_.getResolution())
        near |= 1U << axis;
    for (unsigned i = 0; i < 8; i++)
      if (tree_.nodeChildExists(&node, near ^ i))
        descend(*tree_.getNodeChild(&node, near ^ i), cube.child(near ^ i));
  }

  const octomap::OcTree& tree_;
  std::array<double, 2> xy_;
  double best_ = std::numeric_limits<double>::infinity();
};

}  // namespace

const CSimplePointsMap* CProbOctoMap::getAsSimplePointsMap() const {
  // The tree may have changed through octree() without a trace, so the points are always made anew;
  // those given out before are kept if they are the same, for whoever still looks at them.
  const std::shared_ptr<const CSimplePointsMap> now = occupiedPoints(*m_octree);
  now->boundingBox();  // MRPT computes it at the first call, which may not be two threads' at once
  auto last = std::atomic_load(&m_points);
  while (!last || !samePoints(*last, *now))
    if (std::atomic_compare_exchange_strong(&m_points, &last, now)) return now.get();
  return last.get();
}

void CProbOctoMap::auxParticleFilterCleanUp() {
  std::atomic_store(&m_points, std::shared_ptr<const CSimplePointsMap>());
}

namespace {

/** A map's points, for one matching: MRPT's k-d tree of points serves either 2-D or 3-D searches,
 * not one after the other. */
std::shared_ptr<CSimplePointsMap> pointsToMatch(const octomap::OcTree& tree) {
  auto points = occupiedPoints(tree);
  // MRPT gives up where the two maps' bounding boxes do not overlap, though points may be within
  // reach: a flat scan just below the centres of a layer of voxels. These two, behind the others
  // and beyond any reach, make the box one that overlaps all.
  constexpr float kFar = 1e6F;
  for (const float corner : {-kFar, kFar}) points->insertPoint(corner, corner, corner);
  return points;
}

}  // namespace

void CProbOctoMap::determineMatching2D(const CMetricMap* otherMap,
                                       const mrpt::poses::CPose2D& otherMapPose,
                                       mrpt::tfest::TMatchingPairList& correspondences,
                                       const TMatchingParams& params,
                                       TMatchingExtraResults& extraResults) const {
  pointsToMatch(*m_octree)->determineMatching2D(pointsOf(otherMap).get(), otherMapPose,
                                                correspondences, params, extraResults);
}

void CProbOctoMap::determineMatching3D(const CMetricMap* otherMap,
                                       const mrpt::poses::CPose3D& otherMapPose,
                                       mrpt::tfest::TMatchingPairList& correspondences,
                                       const TMatchingParams& params,
                                       TMatchingExtraResults& extraResults) const {
  pointsToMatch(*m_octree)->determineMatching3D(pointsOf(otherMap).get(), otherMapPose,
                                                correspondences, params, extraResults);
}

float CProbOctoMap::compute3DMatchingRatio(const CMetricMap* otherMap,
                                           const mrpt::poses::CPose3D& otherMapPose,
                                           const TMatchingRatioParams& params) const {
  TMatchingParams matching;
  matching.maxDistForCorrespondence = params.maxDistForCorr;
  mrpt::tfest::TMatchingPairList pairs;
  TMatchingExtraResults results;
  determineMatching3D(otherMap, otherMapPose, pairs, matching, results);
  return results.correspondencesRatio;
}

float CProbOctoMap::squareDistanceToClosestCorrespondence(float x0, float y0) const {
  const double d2 = ClosestInPlane(*m_octree, x0, y0).squareDistance();
  ASSERTMSG_(std::isfinite(d2), "CProbOctoMap: the map has no occupied voxel to measure to");
  return static_cast<float>(d2);
}

// ---------------------------------------------------------------- files and drawing

void CProbOctoMap::loadFromOcTreeFile(const std::string& path) {
  withPath(path, [&] { setOctree(parseOcTreeFile(readFileBytes(path))); });
}

void CProbOctoMap::saveToOcTreeFile(const std::string& path) const { saveOcTree(*m_octree, path); }

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
