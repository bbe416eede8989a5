// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Builds maps from simplemaps and rawlogs. */

#include "mrpt_fusion_maps/recordings/map_builder.h"

#include <mrpt/img/CImage.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/TMetricMapTypesRegistry.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CObservationLocalMap.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/system/string_utils.h>

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "fusion_base/error_text.h"
#include "fusion_base/files.h"
#include "mrpt_fusion_maps/missions.h"
#include "mrpt_fusion_maps/recordings/external_files.h"
#include "mrpt_fusion_maps/recordings/left_out.h"
#include "mrpt_fusion_maps/recordings/object_reader.h"
#include "mrpt_fusion_maps/recordings/robot_path.h"

using namespace mrpt::maps;
using namespace mrpt::obs;
using mrpt::poses::CPose3D;
using mrpt::serialization::CSerializable;

namespace mrpt::fusion {
namespace {

/** Checks the map classes of a definition, because MRPT ignores unknown classes.
 * \exception std::runtime_error If a class is unknown. */
void checkMapNames(const mrpt::config::CConfigFileBase& config, const std::string& section) {
  constexpr std::string_view kSuffix = "_count";
  const auto& kinds = mrpt::maps::internal::TMetricMapTypesRegistry::Instance().getAllRegistered();
  std::vector<std::string> keys;
  config.getAllKeys(section, keys);
  for (const auto& key : keys) {
    const size_t length = key.size() - std::min(key.size(), kSuffix.size());
    if (!mrpt::system::strCmpI(key.substr(length), std::string(kSuffix))) continue;
    const std::string name = key.substr(0, length);
    if (std::none_of(kinds.begin(), kinds.end(),
                     [&](const auto& kind) { return mrpt::system::strCmpI(kind.first, name); }))
      throw std::runtime_error("the section [" + section + "] asks for '" + name +
                               "', which is not a map class");
  }
}

/** The map under construction. */
class Builder {
 public:
  explicit Builder(const BuildParams& params) : params_(params) {
    TSetOfMetricMapInitializers definition;
    if (params.config) {
      checkMapNames(*params.config, params.section);
      definition.loadFromConfigFile(*params.config, params.section);
    } else {
      definition.push_back(CProbOctoMap::TMapDefinition());
    }
    if (definition.size() == 0)
      throw std::runtime_error("the map definition in section [" + params.section +
                               "] asks for no map");
    maps_.setListOfMaps(definition);
  }

  void insert(const CObservation& obs, const CPose3D& robot) {
    if (dynamic_cast<const CObservationMapDiff*>(&obs))
      return leaveOut(ObservationCounter::kindOf(obs), "the map is built from scans");
    loadExternalData(obs);
    if (maps_.insertObservation(obs, robot))
      counter_.countInserted(obs);
    else
      counter_.countNotTaken(obs);
    if (params_.progress) params_.progress(counter_.inserted());
  }
  void leaveOut(const std::string& kind, const std::string& reason, size_t count = 1) {
    counter_.countLeftOut(kind, reason, count);
  }
  void note(const std::string& text) {
    if (params_.note) params_.note(text);
  }

  BuiltMap finish() {
    BuiltMap built;
    built.left_out = counter_.reasons();
    if (counter_.inserted() == 0)
      throw std::runtime_error("no observation in it could be inserted in the map" +
                               (built.left_out.empty() ? "" : " (" + toText(built.left_out) + ")"));
    built.map = maps_.maps.size() == 1 ? CMetricMap::Ptr(maps_.maps.front())
                                       : std::make_shared<CMultiMetricMap>(maps_);
    built.inserted = counter_.inserted();
    built.ignored = counter_.leftOut();
    return built;
  }

 private:
  const BuildParams& params_;
  CMultiMetricMap maps_;
  ObservationCounter counter_;
};

/** Inserts the observations of a frame. \exception std::runtime_error If an object of the frame is
 * not an observation. MRPT reads such an object as null. */
void insertAll(const CSensoryFrame& frame, const CPose3D& robot, Builder& builder) {
  for (const auto& obs : frame) {
    if (!obs) throw std::runtime_error("corrupt: an object in a frame is not an observation");
    builder.insert(*obs, robot);
  }
}

void buildFromSimpleMap(const CSimpleMap& frames, Builder& builder) {
  for (const auto& frame : frames) {
    if (!frame.pose || !frame.sf)
      throw std::runtime_error("corrupt: a keyframe has no pose or no observations");
    CPose3D pose;
    frame.pose->getMean(pose);
    insertAll(*frame.sf, pose, builder);
  }
}

/** Inserts an observation of a rawlog of observations, or counts why it is left out. */
void insertAlongPath(const CObservation& obs, const RobotPath& path, Builder& builder) {
  if (path.empty())
    throw std::runtime_error(
        "has no robot poses (CObservationRobotPose, CObservationOdometry or actions) to place its "
        "observations with");
  if (const auto pose = path.poseFor(obs))
    builder.insert(obs, *pose);
  else
    builder.leaveOut(ObservationCounter::kindOf(obs),
                     path.hasNoTimes() || obs.timestamp == INVALID_TIMESTAMP
                         ? "there is no robot pose before it in the log"
                         : "there is no robot pose at its time");
}

void noteMissingTimes(const RobotPath& path, Builder& builder) {
  if (path.empty()) return;
  if (path.hasNoTimes())
    builder.note(
        "the robot poses have no time stamps: each observation is placed at the last pose before "
        "it in the log");
  builder.leaveOut(path.kind(), "it has no time stamp", path.posesWithoutTime());
}

void buildFromRawlog(Recording& recording, Builder& builder) {
  RobotPath path = recording.robotPath();
  noteMissingTimes(path, builder);
  CPose3D dead_reckoning;  // pose in the actions format
  bool has_actions = false;
  recording.forEachObject([&](const CSerializable& object) {
    if (const auto* actions = dynamic_cast<const CActionCollection*>(&object)) {
      CPose3D increment;
      if (actions->getFirstMovementEstimationMean(increment))
        dead_reckoning = dead_reckoning + increment;
      has_actions = true;
    } else if (const auto* frame = dynamic_cast<const CSensoryFrame*>(&object)) {
      if (!has_actions) throw std::runtime_error("has observations but no robot movements");
      insertAll(*frame, dead_reckoning, builder);
    } else if (const auto* obs = dynamic_cast<const CObservation*>(&object)) {
      if (isRobotPose(*obs))
        path.pass(*obs);
      else
        insertAlongPath(*obs, path, builder);
    }
  });
}

}  // namespace

BuiltMap buildFrom(const std::string& path, const CSerializable& first, Recording* recording,
                   const BuildParams& params) {
  Builder builder(params);
  mrpt::img::CImage::setImagesPathBase(imagesDirectoryOf(path));
  if (const auto* frames = dynamic_cast<const CSimpleMap*>(&first))
    buildFromSimpleMap(*frames, builder);
  else
    buildFromRawlog(*recording, builder);
  return builder.finish();
}

BuiltMap buildMap(const std::string& path, const BuildParams& params) {
  return withPath(path, [&] {
    beginningOf(path);  // throws with the reason if the file cannot be read
    ObjectReader reader(path);
    const auto first = reader.next();
    if (!isRecording(*first)) throw std::runtime_error("is not a simplemap or a rawlog");
    if (dynamic_cast<const CSimpleMap*>(first.get()))
      return buildFrom(path, *first, nullptr, params);
    Recording recording(path, reader, first);
    if (const auto& sent = recording.latestMaps();
        sent.count() > 0 && recording.robotPath().empty()) {
      if (params.config && params.note)
        params.note("holds the map that a robot sent: the map definition has no effect");
      return BuiltMap{onlyMapOf(sent.maps()), sent.count(), 0, {}};
    }
    return buildFrom(path, *first, &recording, params);
  });
}

}  // namespace mrpt::fusion
