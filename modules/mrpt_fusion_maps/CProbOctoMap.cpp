// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * CProbOctoMap: its definition in settings files, its options, construction and serialization. */

#include <mrpt/fusion/compat.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/serialization/CArchive.h>

#include <cmath>
#include <initializer_list>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "fusion_base/config_check.h"
#include "fusion_base/error_text.h"
#include "fusion_base/printable.h"
#include "fusion_link/dds_link.h"
#include "fusion_link/statements.h"
#include "fusion_octree/build.h"
#include "fusion_octree/files.h"
#include "fusion_octree/insertion/scan_insertion.h"
#include "fusion_octree/resolution.h"
#include "mrpt_fusion_maps/archives/blobs.h"
#include "mrpt_fusion_maps/archives/flags.h"
#include "mrpt_fusion_maps/archives/sources.h"
#include "mrpt_fusion_maps/map_publisher.h"

using namespace mrpt::fusion;
using namespace mrpt::maps;

IMPLEMENTS_SERIALIZABLE(CProbOctoMap, CMetricMap, mrpt::maps)
MAP_DEFINITION_REGISTER("mrpt::maps::CProbOctoMap,probOctoMap", mrpt::maps::CProbOctoMap)

// ---------------------------------------------------------------- map definition and options

/** Largest range of a map definition, m. */
constexpr double kMaxRange = 1e6;

namespace {

/** Reads to whom a map is sent. */
void readLink(const mrpt::config::CConfigFileBase& source, const std::string& section,
              TeamLink& link) {
  checkKeys(source, section, {"robot", "domain", "peers", "journal"});
  link.robot = source.read_string(section, "robot", link.robot);
  if (!isName(link.robot))
    THROW_EXCEPTION("[" + section + "] robot is not a name of 1 to " +
                    std::to_string(kMostNameCharacters) + " printable characters");
  link.domain = static_cast<uint32_t>(
      readNumber(source, section, "domain", link.domain, 0, kMostDomain, NumberKind::Whole));
  link.journal = source.read_string(section, "journal", link.journal);
  std::istringstream peers(source.read_string(section, "peers", ""));
  for (std::string peer; peers >> peer;) link.peers.push_back(peer);
}

}  // namespace

CProbOctoMap::TMapDefinition::TMapDefinition() = default;

void CProbOctoMap::TMapDefinition::loadFromConfigFile_map_specific(
    const mrpt::config::CConfigFileBase& source, const std::string& prefix) {
  const std::string creation = prefix + "_creationOpts", likelihood = prefix + "_likelihoodOpts";
  // MRPT has read the enable... options before.
  checkKeys(source, creation,
            {"resolution", "enableSaveAs3DObject", "enableObservationLikelihood",
             "enableObservationInsertion"});
  resolution =
      readNumber(source, creation, "resolution", resolution, kMinResolution, kMaxResolution);
  insertionOpts.loadFromConfigFile(source, prefix + "_insertOpts");
  checkKeys(source, likelihood, {"decimation"});
  likelihoodOpts.decimation = static_cast<uint32_t>(readNumber(
      source, likelihood, "decimation", likelihoodOpts.decimation, 1, 1e9, NumberKind::Whole));
  readLink(source, prefix + "_linkOpts", linkOpts);
}

void CProbOctoMap::TMapDefinition::dumpToTextStream_map_specific(std::ostream& out) const {
  LOADABLEOPTS_DUMP_VAR(resolution, double);
  if (!linkOpts.robot.empty())
    out << "sent as robot '" << printable(linkOpts.robot) << "' to domain " << linkOpts.domain
        << "\n";
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
  if (!def.linkOpts.robot.empty()) map->m_publisher = std::make_shared<MapPublisher>(def.linkOpts);
  return createdMap(std::move(map));
}

namespace {

/** An insertion option that is a probability. All options of the list are loaded, checked and
 * saved. */
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
  loaded.maxrange = readNumber(source, section, "maxrange", maxrange, -1, kMaxRange);
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
  MRPT_SAVE_CONFIG_VAR_COMMENT(maxrange, "Length to which beams are inserted, m (-1: whole beams)");
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
  replaceTree(std::make_unique<octomap::OcTree>(resolution));
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
      m_octree(std::make_unique<octomap::OcTree>(*o.m_octree)),
      m_tree_state(o.m_tree_state.innerNodes()),
      m_sources(o.m_sources),
      m_sources_hash(o.m_sources_hash),
      m_robot_map(o.m_robot_map) {}

CProbOctoMap& CProbOctoMap::operator=(const CProbOctoMap& o) {
  CProbOctoMap copy(o);
  copy.m_publisher = m_publisher;
  *this = std::move(copy);
  return *this;
}

CProbOctoMap::~CProbOctoMap() {
  if (m_publisher && m_octree) m_publisher->offerLast(*m_octree);
}

void CProbOctoMap::publish() noexcept {
  if (m_publisher) m_publisher->offer(*m_octree);
}

void CProbOctoMap::replaceTree(std::unique_ptr<octomap::OcTree> tree) {
  m_octree = std::move(tree);
  const bool empty = m_octree->size() == 0;
  m_tree_state = TreeState(static_cast<uint8_t>(empty ? InnerNodes::Pruned : InnerNodes::Unknown));
  m_sources.clear();
  m_robot_map.reset();
}

void CProbOctoMap::setOctree(std::unique_ptr<octomap::OcTree> tree) {
  ASSERTMSG_(tree, "CProbOctoMap::setOctree(): no tree");
  replaceTree(std::move(tree));
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

void CProbOctoMap::internal_clear() {
  m_octree->clear();
  m_tree_state.setInnerNodes(static_cast<uint8_t>(InnerNodes::Pruned));
  m_sources.clear();
  m_robot_map.reset();
}

std::string CProbOctoMap::asString() const {
  return mrpt::format("Probabilistic octomap, voxels of %.03f m, %zu nodes", getResolution(),
                      size());
}

// ---------------------------------------------------------------- serialization

namespace {

/** Checks options and thresholds of a stream. Infinite log-odds are thresholds that clamp nothing.
 */
void checkNumbers(std::initializer_list<double> numbers) {
  for (const double number : numbers)
    if (std::isnan(number)) THROW_EXCEPTION("corrupt stream: an option is not a number");
}

}  // namespace

/** Version 1 has sources. A map without sources is readable by earlier versions of this library. */
uint8_t CProbOctoMap::serializeGetVersion() const { return m_sources.empty() ? 0 : 1; }

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
  if (!m_sources.empty()) SourcesOfMap::write(out, *this);
  writeEndMark(out);
}

void CProbOctoMap::serializeFrom(mrpt::serialization::CArchive& in, uint8_t version) {
  if (version > 1) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  // The stream is read into another map first, so that this map stays as it was if the stream ends
  // early.
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
  checkFlags(map.genericMapParams);
  checkFlags(map.renderingOptions);
  checkFlags(i.pruning);
  checkNumbers({i.maxrange, i.occupancyThres, i.probHit, i.probMiss, i.clampingThresMin,
                i.clampingThresMax, m.clamp_min, m.clamp_max, m.hit, m.miss,
                m.occupancy_threshold});
  checkResolution(resolution);
  map.m_octree = std::make_unique<octomap::OcTree>(resolution);
  map.m_tree_state = TreeState(static_cast<uint8_t>(InnerNodes::Unknown));
  OcTreeAccess::setSensorModel(*map.m_octree, m);
  const std::string nodes = readBlob(in);
  if (version > 0) SourcesOfMap::read(in, map);
  readEndMark(in);
  parseNodes(nodes, *map.m_octree);
  *this = std::move(map);
}
