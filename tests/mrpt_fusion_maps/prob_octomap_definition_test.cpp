// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the map definition and the options of CProbOctoMap. */

#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/COctoMap.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "support/mrpt_tools.h"
#include "support/observations.h"

using namespace map_tests;
using mrpt::config::CConfigFileMemory;
using mrpt::maps::CMultiMetricMap;
using mrpt::maps::COctoMap;
using mrpt::maps::CProbOctoMap;
using mrpt::maps::TSetOfMetricMapInitializers;

namespace {

const char* const kDefinition = R"([Mapping]
probOctoMap_count = 1
[Mapping_probOctoMap_00_creationOpts]
resolution = 0.07
[Mapping_probOctoMap_00_insertOpts]
maxrange = 12.5
pruning = false
occupancyThres = 0.6
probHit = 0.82
probMiss = 0.32
clampingThresMin = 0.06
clampingThresMax = 0.95
[Mapping_probOctoMap_00_likelihoodOpts]
decimation = 4
)";

/** Creates the maps of a definition. */
CMultiMetricMap mapsOf(const std::string& ini) {
  TSetOfMetricMapInitializers definition;
  definition.loadFromConfigFile(CConfigFileMemory(ini), "Mapping");
  CMultiMetricMap maps;
  maps.setListOfMaps(definition);
  return maps;
}

}  // namespace

TEST(ProbOctoMapDefinition, ALinkIsReadAndChecked) {
  const auto definitionOf = [](const std::string& keys) {
    CProbOctoMap::TMapDefinition definition;
    definition.loadFromConfigFile(CConfigFileMemory("[Map_linkOpts]\n" + keys), "Map");
    return definition.linkOpts;
  };
  EXPECT_TRUE(definitionOf("").robot.empty());
  const auto link = definitionOf("robot = r1\ndomain = 7\npeers = 10.0.0.1 10.0.0.2\njournal = /j");
  EXPECT_EQ("r1", link.robot);
  EXPECT_EQ(7U, link.domain);
  EXPECT_EQ((std::vector<std::string>{"10.0.0.1", "10.0.0.2"}), link.peers);
  EXPECT_EQ("/j", link.journal);
  for (const std::string& wrong : {"robot = " + std::string(64, 'n'), std::string("domain = 233"),
                                   std::string("domain = 1.5"), std::string("robbot = r1")})
    EXPECT_NE(errorOf([&] { definitionOf(wrong); }).find("[Map_linkOpts]"), std::string::npos)
        << wrong;
}

TEST(ProbOctoMapDefinition, AMapThatCannotBeSentSaysSoOnceAndIsBuilt) {
  testing::internal::CaptureStderr();
  const auto points = cloudOf(domePoints(1));
  CProbOctoMap without;
  without.insertObservation(*points);
  {
    // No address: the link cannot be opened.
    const auto maps = mapsOf(
        "[Mapping]\nprobOctoMap_count = 1\n[Mapping_probOctoMap_00_linkOpts]\nrobot = r1\n"
        "domain = 13\npeers = no*address\n");
    const auto map = maps.mapByClass<CProbOctoMap>();
    ASSERT_TRUE(map);
    EXPECT_TRUE(map->insertObservation(*points));
    EXPECT_TRUE(sameTree(map->octree(), without.octree()));
    map->insertObservation(*points);
  }
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_EQ(0U, said.find("CProbOctoMap: the map of robot 'r1' is not sent: ")) << said;
  EXPECT_EQ(1, std::count(said.begin(), said.end(), '\n')) << said;
}

TEST(ProbOctoMapDefinition, AnIniSectionMakesAMapWithItsOptions) {
  const CMultiMetricMap maps = mapsOf(kDefinition);
  ASSERT_EQ(1U, maps.maps.size());
  const auto map = maps.mapByClass<CProbOctoMap>();
  ASSERT_TRUE(map);
  EXPECT_EQ(0.07, map->getResolution());
  const auto& i = map->insertionOptions;
  EXPECT_EQ(12.5, i.maxrange);
  EXPECT_FALSE(i.pruning);
  EXPECT_EQ(0.6, i.occupancyThres);
  EXPECT_EQ(0.82, i.probHit);
  EXPECT_EQ(0.32, i.probMiss);
  EXPECT_EQ(0.06, i.clampingThresMin);
  EXPECT_EQ(0.95, i.clampingThresMax);
  EXPECT_EQ(4U, map->likelihoodOptions.decimation);
  EXPECT_FLOAT_EQ(0.82F, static_cast<float>(map->octree().getProbHit()));
  EXPECT_FLOAT_EQ(0.6F, static_cast<float>(map->octree().getOccupancyThres()));
  EXPECT_TRUE(map->isEmpty());
}

TEST(ProbOctoMapDefinition, TheDefaultsAreCOctoMaps) {
  const CMultiMetricMap maps = mapsOf("[Mapping]\nprobOctoMap_count = 1\noctoMap_count = 1\n");
  const auto ours = maps.mapByClass<CProbOctoMap>();
  const auto theirs = maps.mapByClass<COctoMap>();
  ASSERT_TRUE(ours && theirs);
  EXPECT_EQ(theirs->getResolution(), ours->getResolution());
  const auto& t = theirs->insertionOptions;
  const auto& o = ours->octree();
  EXPECT_EQ(t.maxrange, ours->insertionOptions.maxrange);
  EXPECT_EQ(t.pruning, ours->insertionOptions.pruning);
  EXPECT_EQ(t.getOccupancyThresLog(), o.getOccupancyThresLog());
  EXPECT_EQ(t.getProbHitLog(), o.getProbHitLog());
  EXPECT_EQ(t.getProbMissLog(), o.getProbMissLog());
  EXPECT_EQ(t.getClampingThresMinLog(), o.getClampingThresMinLog());
  EXPECT_EQ(t.getClampingThresMaxLog(), o.getClampingThresMaxLog());
}

TEST(ProbOctoMapDefinition, SeveralMapsEachHaveTheirOwnSections) {
  const CMultiMetricMap maps = mapsOf(
      "[Mapping]\nprobOctoMap_count = 2\n"
      "[Mapping_probOctoMap_00_creationOpts]\nresolution = 0.3\n"
      "[Mapping_probOctoMap_01_creationOpts]\nresolution = 0.4\n");
  ASSERT_EQ(2U, maps.maps.size());
  EXPECT_EQ(0.3, maps.mapByClass<CProbOctoMap>(0)->getResolution());
  EXPECT_EQ(0.4, maps.mapByClass<CProbOctoMap>(1)->getResolution());
}

TEST(ProbOctoMapDefinition, ADefinedMapTakesTheObservationsOfItsSet) {
  CMultiMetricMap maps = mapsOf(kDefinition);
  ASSERT_TRUE(maps.insertObservation(*scan2d()));
  CProbOctoMap alone(0.07);
  alone.insertionOptions = maps.mapByClass<CProbOctoMap>()->insertionOptions;
  alone.insertObservation(*scan2d());
  EXPECT_TRUE(sameTree(alone.octree(), maps.mapByClass<CProbOctoMap>()->octree()));
}

TEST(ProbOctoMapDefinition, TheGenericOptionsOfMapsAreItsOwnToo) {
  const CMultiMetricMap maps = mapsOf(
      "[Mapping]\nprobOctoMap_count = 1\n[Mapping_probOctoMap_00_creationOpts]\n"
      "enableSaveAs3DObject = false\nenableObservationLikelihood = false\n"
      "enableObservationInsertion = false\n");
  const auto& generic = maps.mapByClass<CProbOctoMap>()->genericMapParams;
  EXPECT_FALSE(generic.enableSaveAs3DObject);
  EXPECT_FALSE(generic.enableObservationLikelihood);
  EXPECT_FALSE(generic.enableObservationInsertion);
}

TEST(ProbOctoMapDefinition, KeysAreFoundWhateverTheirCase) {
  const CMultiMetricMap maps = mapsOf(
      "[Mapping]\nPROBoctomap_count = 1\n"
      "[Mapping_probOctoMap_00_insertOpts]\nProbHit = 0.9\n");
  EXPECT_EQ(0.9, maps.mapByClass<CProbOctoMap>()->insertionOptions.probHit);
}

TEST(ProbOctoMapDefinition, UnknownKeysAndValuesOutOfRangeAreNamedWithTheirSection) {
  const struct {
    std::string section, line, named;
  } kBad[] = {{"creationOpts", "resolutoin = 0.1", "resolutoin"},
              {"creationOpts", "resolution = 0", "resolution = 0"},
              {"creationOpts", "resolution = -0.1", "resolution = -0.1"},
              {"creationOpts", "resolution = fine", "resolution = fine"},
              {"creationOpts", "resolution = 0.1 m", "resolution = 0.1 m"},
              {"insertOpts", "probhits = 0.7", "probhits"},
              {"insertOpts", "probHit = 1.5", "probHit = 1.5"},
              {"insertOpts", "probHit = 1", "probHit = 1"},
              {"insertOpts", "probHit = 0.4", "probHit = 0.4"},
              {"insertOpts", "probMiss = nan", "probMiss = nan"},
              {"insertOpts", "clampingThresMin = 0.98", "clampingThresMin = 0.98"},
              {"insertOpts", "maxrange = 0", "maxrange = 0"},
              {"insertOpts", "maxrange = -0.5", "maxrange = -0.5"},
              {"insertOpts", "pruning = ture", "pruning = ture"},
              {"likelihoodOpts", "decimate = 3", "decimate"},
              {"likelihoodOpts", "decimation = 0", "decimation = 0"},
              {"likelihoodOpts", "decimation = -1", "decimation = -1"},
              {"likelihoodOpts", "decimation = 2.5", "decimation = 2.5"}};
  for (const auto& bad : kBad) {
    const std::string section = "Mapping_probOctoMap_00_" + bad.section;
    const std::string error = errorOf(
        [&] { mapsOf("[Mapping]\nprobOctoMap_count = 1\n[" + section + "]\n" + bad.line + "\n"); });
    EXPECT_NE(std::string::npos, error.find("[" + section + "]")) << bad.line << ": " << error;
    EXPECT_NE(std::string::npos, error.find(bad.named)) << bad.line << ": " << error;
  }
}

TEST(ProbOctoMapDefinition, OptionsThatAreRefusedChangeNothing) {
  CProbOctoMap::TInsertionOptions options;
  options.probHit = 0.8;
  EXPECT_ANY_THROW(options.loadFromConfigFile(
      CConfigFileMemory(std::string("[o]\nmaxrange = 5\nprobHit = 0.9\nprobMiss = 0.6\n")), "o"));
  EXPECT_EQ(-1, options.maxrange);
  EXPECT_EQ(0.8, options.probHit);
  EXPECT_EQ(0.4, options.probMiss);
}

TEST(ProbOctoMapDefinition, ItsTextNamesEveryOption) {
  TSetOfMetricMapInitializers definition;
  definition.loadFromConfigFile(CConfigFileMemory(std::string(kDefinition)), "Mapping");
  std::ostringstream text;
  definition.dumpToTextStream(text);
  for (const char* name : {"resolution", "maxrange", "pruning", "occupancyThres", "probHit",
                           "probMiss", "clampingThresMin", "clampingThresMax", "decimation"})
    EXPECT_NE(std::string::npos, text.str().find(name)) << name << " in\n" << text.str();
}

TEST(ProbOctoMapDefinition, InsertionOptionsComeBackFromTheConfigFileTheyAreSavedTo) {
  CProbOctoMap::TInsertionOptions saved, loaded;
  saved.maxrange = 3.5;
  saved.pruning = false;
  saved.occupancyThres = 0.61;
  saved.probHit = 0.77;
  saved.probMiss = 0.31;
  saved.clampingThresMin = 0.05;
  saved.clampingThresMax = 0.94;
  CConfigFileMemory file;
  saved.saveToConfigFile(file, "section");
  size_t comments = 0;  // explanations of keys
  std::istringstream lines(file.getContent());
  for (std::string line; std::getline(lines, line);)
    comments += line.find('=') < line.find("//") && line.find("//") + 10 < line.size();
  EXPECT_EQ(7U, comments) << file.getContent();
  // From the text, as a file would be: MRPT pads the names of keys until they are parsed.
  loaded.loadFromConfigFile(CConfigFileMemory(file.getContent()), "section");
  EXPECT_EQ(saved.maxrange, loaded.maxrange);
  EXPECT_EQ(saved.pruning, loaded.pruning);
  EXPECT_EQ(saved.occupancyThres, loaded.occupancyThres);
  EXPECT_EQ(saved.probHit, loaded.probHit);
  EXPECT_EQ(saved.probMiss, loaded.probMiss);
  EXPECT_EQ(saved.clampingThresMin, loaded.clampingThresMin);
  EXPECT_EQ(saved.clampingThresMax, loaded.clampingThresMax);
}
