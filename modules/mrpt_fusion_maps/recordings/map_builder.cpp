// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Builds maps from simplemaps and rawlogs. */

#include "mrpt_fusion_maps/recordings/map_builder.h"

#include <mrpt/img/CImage.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/TMetricMapTypesRegistry.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DInterpolator.h>
#include <mrpt/system/string_utils.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "fusion_base/error_text.h"
#include "mrpt_fusion_maps/recordings/object_reader.h"

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
    obs.load();
    if (maps_.insertObservation(obs, robot))
      inserted_++;
    else
      ignored_++;
    if (params_.progress) params_.progress(inserted_);
  }
  void ignore() { ignored_++; }

  BuiltMap finish() {
    if (inserted_ == 0)
      throw std::runtime_error("no observation in it could be inserted in the map");
    BuiltMap built;
    built.map = maps_.maps.size() == 1 ? CMetricMap::Ptr(maps_.maps.front())
                                       : std::make_shared<CMultiMetricMap>(maps_);
    built.inserted = inserted_;
    built.ignored = ignored_;
    return built;
  }

 private:
  const BuildParams& params_;
  CMultiMetricMap maps_;
  size_t inserted_ = 0, ignored_ = 0;
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

/** Reads the path of the robot from a rawlog in the observations format. */
mrpt::poses::CPose3DInterpolator readPath(const std::string& path) {
  mrpt::poses::CPose3DInterpolator poses, odometry;
  ObjectReader reader(path);
  while (const auto object = reader.next()) {
    if (const auto* pose = dynamic_cast<const CObservationRobotPose*>(object.get()))
      poses.insert(pose->timestamp, pose->pose.mean);
    else if (const auto* odo = dynamic_cast<const CObservationOdometry*>(object.get()))
      odometry.insert(odo->timestamp, CPose3D(odo->odometry));
  }
  auto& known = poses.empty() ? odometry : poses;
  known.setInterpolationMethod(mrpt::poses::imLinearSlerp);
  return known;
}

void buildFromRawlog(const std::string& path, Builder& builder) {
  const auto known_poses = readPath(path);
  CPose3D dead_reckoning;  // pose in the actions format
  bool has_actions = false;
  ObjectReader reader(path);
  while (const auto object = reader.next()) {
    if (const auto* actions = dynamic_cast<const CActionCollection*>(object.get())) {
      CPose3D increment;
      if (actions->getFirstMovementEstimationMean(increment))
        dead_reckoning = dead_reckoning + increment;
      has_actions = true;
    } else if (const auto* frame = dynamic_cast<const CSensoryFrame*>(object.get())) {
      if (!has_actions) throw std::runtime_error("has observations but no robot movements");
      insertAll(*frame, dead_reckoning, builder);
    } else if (dynamic_cast<const CObservationRobotPose*>(object.get()) ||
               dynamic_cast<const CObservationOdometry*>(object.get())) {
      continue;  // it is in known_poses
    } else if (const auto* obs = dynamic_cast<const CObservation*>(object.get())) {
      if (known_poses.empty())
        throw std::runtime_error(
            "has no robot poses (CObservationRobotPose, CObservationOdometry or actions) to place "
            "its observations with");
      CPose3D pose;
      bool valid = false;
      known_poses.interpolate(obs->timestamp, pose, valid);
      if (valid)
        builder.insert(*obs, pose);
      else
        builder.ignore();
    }
  }
}

/** Returns the directory of the external files of a rawlog, with a final '/': "<name>_Images" or
 * "Images" in the folder of the rawlog. CRawlog::detectImagesDirectory() returns it without the
 * '/'. */
std::string imagesDirectoryOf(const std::string& rawlog) {
  const std::filesystem::path file(rawlog);
  const auto folder = std::filesystem::absolute(file).parent_path();
  const auto own = folder / (file.stem().string() + "_Images");
  return (std::filesystem::is_directory(own) ? own : folder / "Images").string() + "/";
}

}  // namespace

BuiltMap buildFrom(const std::string& path, const CSerializable& first, const BuildParams& params) {
  Builder builder(params);
  if (const auto* frames = dynamic_cast<const CSimpleMap*>(&first)) {
    buildFromSimpleMap(*frames, builder);
  } else {
    mrpt::img::CImage::setImagesPathBase(imagesDirectoryOf(path));
    buildFromRawlog(path, builder);
  }
  return builder.finish();
}

BuiltMap buildMap(const std::string& path, const BuildParams& params) {
  return withPath(path, [&] {
    const auto first = firstObject(path);
    if (!isRecording(*first)) throw std::runtime_error("is not a simplemap or a rawlog");
    return buildFrom(path, *first, params);
  });
}

}  // namespace mrpt::fusion
