// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/map_files.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/io/CStream.h>
#include <mrpt/maps/CColouredOctoMap.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/COccupancyGridMap3D.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/TMetricMapTypesRegistry.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DInterpolator.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/system/filesystem.h>
#include <mrpt/system/string_utils.h>

#include "fusion_base/error_text.h"
#include "fusion_base/files.h"
#include "fusion_octree/files.h"
#define ZLIB_CONST  // input is const
#include <zlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <vector>

using namespace mrpt::maps;
using namespace mrpt::obs;
using mrpt::poses::CPose3D;
using mrpt::serialization::CSerializable;

namespace mrpt::fusion {
namespace {

/** A file, gz-compressed or not, as MRPT's archives read it. MRPT's own takes a file that ends
 * early, amid a number or a compressed block, for one that ends there; this one throws. */
class GzFile : public mrpt::io::CStream {
 public:
  explicit GzFile(const std::string& path) : file_(::gzopen(path.c_str(), "rb")) {
    if (!file_) throw std::runtime_error("cannot be opened");
    ::gzbuffer(file_, 1U << 18U);
  }
  ~GzFile() override { ::gzclose(file_); }
  GzFile(const GzFile&) = delete;
  GzFile& operator=(const GzFile&) = delete;

  size_t Read(void* buffer, size_t count) override {
    auto* to = static_cast<char*>(buffer);
    size_t done = 0;
    while (done < count) {
      const auto block = static_cast<unsigned>(std::min<size_t>(count - done, 1U << 30U));
      const int n = ::gzread(file_, to + done, block);
      if (n <= 0) break;
      done += static_cast<size_t>(n);
    }
    position_ += done;
    int error = Z_OK;
    ::gzerror(file_, &error);
    if (error != Z_OK && error != Z_STREAM_END)
      throw std::runtime_error("the compressed data ends early or is damaged");
    if (done < count && done > 0) throw std::runtime_error("the file ends early");
    return done;
  }
  /** Bytes read so far, uncompressed. */
  uint64_t getPosition() const override { return position_; }

  size_t Write(const void*, size_t) override { THROW_EXCEPTION("not for writing"); }
  uint64_t Seek(int64_t, TSeekOrigin) override { THROW_EXCEPTION("not for seeking"); }
  uint64_t getTotalBytesCount() const override { THROW_EXCEPTION("size not known"); }

 private:
  gzFile file_;
  uint64_t position_ = 0;
};

/** Reads the MRPT objects of a file one by one. */
class ObjectReader {
 public:
  explicit ObjectReader(const std::string& path) : file_(path) {}

  /** The next object; null at the end of the file. */
  CSerializable::Ptr next() {
    auto archive = mrpt::serialization::archiveFrom(file_);
    const uint64_t start = file_.getPosition();
    try {
      auto object = archive.ReadObject();
      if (!object) throw std::runtime_error("an empty object");
      count_++;
      return object;
    } catch (const std::exception& e) {
      const bool at_end = dynamic_cast<const mrpt::serialization::CExceptionEOF*>(&e) &&
                          file_.getPosition() == start;
      if (at_end && count_ > 0) return nullptr;
      if (count_ == 0)
        throw std::runtime_error("not a map, simplemap or rawlog file, or truncated (" +
                                 messageOf(e) + ")");
      throw std::runtime_error("truncated or corrupt after " + std::to_string(count_) +
                               " objects (" + messageOf(e) + ")");
    }
  }

 private:
  GzFile file_;
  size_t count_ = 0;
};

/** \exception If a map definition asks for maps of a kind that MRPT does not know: it passes over
 * them in silence. */
void checkMapNames(const mrpt::config::CConfigFileBase& config, const std::string& section) {
  constexpr std::string_view kSuffix = "_count";
  const auto& kinds = internal::TMetricMapTypesRegistry::Instance().getAllRegistered();
  std::vector<std::string> keys;
  config.getAllKeys(section, keys);
  for (const auto& key : keys) {
    const size_t length = key.size() - std::min(key.size(), kSuffix.size());
    if (!mrpt::system::strCmpI(key.substr(length), std::string(kSuffix))) continue;
    const std::string name = key.substr(0, length);
    if (std::none_of(kinds.begin(), kinds.end(),
                     [&](const auto& kind) { return mrpt::system::strCmpI(kind.first, name); }))
      throw std::runtime_error("the section [" + section + "] asks for '" + name +
                               "', which is no map class");
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

/** Inserts all observations that were made at once. \exception If there is an object in their stead
 * that is none: MRPT reads it as null. */
void insertAll(const CSensoryFrame& frame, const CPose3D& robot, Builder& builder) {
  for (const auto& obs : frame) {
    if (!obs) throw std::runtime_error("corrupt: what should be an observation is none");
    builder.insert(*obs, robot);
  }
}

void buildFromSimpleMap(const CSimpleMap& frames, Builder& builder) {
  for (const auto& frame : frames) {
    if (!frame.pose || !frame.sf) throw std::runtime_error("corrupt: a keyframe is not whole");
    CPose3D pose;
    frame.pose->getMean(pose);
    insertAll(*frame.sf, pose, builder);
  }
}

/** The robot's path as a rawlog of observations tells it. */
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
  CPose3D dead_reckoning;  // of the actions format
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
      continue;  // in known_poses
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

/** Where a rawlog keeps what it stores outside, with a final '/': "<name>_Images" beside it, or
 * "Images". (CRawlog::detectImagesDirectory() joins its parts without the '/'.) */
std::string imagesDirectoryOf(const std::string& rawlog) {
  const std::filesystem::path file(rawlog);
  const auto folder = std::filesystem::absolute(file).parent_path();
  const auto own = folder / (file.stem().string() + "_Images");
  return (std::filesystem::is_directory(own) ? own : folder / "Images").string() + "/";
}

bool isRecording(const CSerializable& first) {
  return dynamic_cast<const CSimpleMap*>(&first) || dynamic_cast<const CObservation*>(&first) ||
         dynamic_cast<const CActionCollection*>(&first) ||
         dynamic_cast<const CSensoryFrame*>(&first);
}

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

/** Whether one robot's map tells more than another of its maps: a whole one more than its edges, a
 * later one more than an earlier. */
bool tellsMore(const CObservationLocalMap& map, const CObservationLocalMap& than) {
  const auto isWhole = [](const CObservationLocalMap& o) {
    return o.map && asProbOctoMap(*o.map) != nullptr;
  };
  const bool whole = isWhole(map);
  return whole != isWhole(than) ? whole : map.sequence >= than.sequence;
}

/** The latest map of each robot in a rawlog. */
std::vector<CObservationLocalMap::Ptr> latestMaps(const std::string& path) {
  std::vector<CObservationLocalMap::Ptr> latest;
  ObjectReader reader(path);
  while (const auto object = reader.next()) {
    const auto map = std::dynamic_pointer_cast<CObservationLocalMap>(object);
    if (!map) continue;
    const auto known = std::find_if(latest.begin(), latest.end(), [&](const auto& other) {
      return other->sensorLabel == map->sensorLabel;
    });
    if (known == latest.end())
      latest.push_back(map);
    else if (tellsMore(*map, **known))
      *known = map;
  }
  return latest;
}

/** \a bytes in gzip's format, compressed in memory: MRPT's compress_gz_data_block goes through a
 * named pipe in /tmp, and what it returns has been seen cut short. */
std::string gzCompressed(std::string_view bytes) {
  z_stream stream{};
  constexpr int kGzipFormat = 16;
  if (::deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, MAX_WBITS + kGzipFormat, 8,
                     Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  std::string compressed;
  std::vector<Bytef> block(1U << 18U);
  int state = Z_OK;
  while (state != Z_STREAM_END) {
    if (stream.avail_in == 0 && !bytes.empty()) {  // zlib counts in 32 bits
      const auto next = bytes.substr(0, 1U << 30U);
      stream.next_in = reinterpret_cast<const Bytef*>(next.data());
      stream.avail_in = static_cast<uInt>(next.size());
      bytes.remove_prefix(next.size());
    }
    stream.next_out = block.data();
    stream.avail_out = static_cast<uInt>(block.size());
    state = ::deflate(&stream, bytes.empty() ? Z_FINISH : Z_NO_FLUSH);
    compressed.append(block.begin(), block.end() - stream.avail_out);
  }
  ::deflateEnd(&stream);
  return compressed;
}

/** The first object of a file that is not an octree's. \exception If it cannot be read at all. */
CSerializable::Ptr firstObject(const std::string& path) {
  beginningOf(path);  // says why, if nothing can be read
  return ObjectReader(path).next();
}

/** Makes an octomap of a map of one class; null if it is of another. */
using View = std::shared_ptr<const CProbOctoMap> (*)(const CMetricMap&);

std::shared_ptr<const CProbOctoMap> itself(const CMetricMap& map) {
  const auto* ours = dynamic_cast<const CProbOctoMap*>(&map);
  return {std::shared_ptr<const CProbOctoMap>(), ours};  // not owned
}

template <class Map>
std::shared_ptr<const CProbOctoMap> converted(const CMetricMap& map) {
  const auto* theirs = dynamic_cast<const Map*>(&map);
  return theirs ? std::make_shared<const CProbOctoMap>(*theirs) : nullptr;
}

/** The first map that a view takes: this one, or one of a set. */
std::shared_ptr<const CProbOctoMap> findIn(const CMetricMap& map, View view) {
  if (auto found = view(map)) return found;
  if (const auto* several = dynamic_cast<const CMultiMetricMap*>(&map))
    for (const auto& m : several->maps)
      if (auto found = findIn(*m, view)) return found;
  return nullptr;
}

}  // namespace

std::shared_ptr<const CProbOctoMap> asProbOctoMap(const CMetricMap& map) {
  // Those that keep most come first, whatever the order of a set.
  for (const auto view : {&itself, &converted<COctoMap>, &converted<CColouredOctoMap>,
                          &converted<COccupancyGridMap3D>})
    if (auto found = findIn(map, view)) return found;
  return nullptr;
}

std::shared_ptr<const CProbOctoMap> asProbOctoMap(const CMetricMap::ConstPtr& map) {
  const auto octomap = asProbOctoMap(*map);
  if (!octomap) return nullptr;
  return {std::make_shared<std::pair<CMetricMap::ConstPtr, decltype(octomap)>>(map, octomap),
          octomap.get()};
}

BuiltMap buildMap(const std::string& path, const BuildParams& params) {
  return withPath(path, [&] {
    const auto first = firstObject(path);
    if (!isRecording(*first)) throw std::runtime_error("is not a simplemap or a rawlog");
    return buildFrom(path, *first, params);
  });
}

CMetricMap::Ptr loadAnyMap(const std::string& path, const BuildParams& params) {
  return withPath(path, [&]() -> CMetricMap::Ptr {
    if (isOcTreeFile(beginningOf(path)))
      return std::make_shared<CProbOctoMap>(parseOcTreeFile(readFileBytes(path)));

    const auto first = firstObject(path);
    if (isRecording(*first)) {
      const auto robots = latestMaps(path);
      if (robots.empty()) return buildFrom(path, *first, params).map;
      if (robots.size() > 1)
        throw std::runtime_error("holds the maps of " + std::to_string(robots.size()) +
                                 " robots, not one map");
      if (!robots.front()->map) throw std::runtime_error("the robot's map is missing in it");
      return robots.front()->map;
    }
    auto map = std::dynamic_pointer_cast<CMetricMap>(first);
    if (!map)
      throw std::runtime_error(std::string("a ") + first->GetRuntimeClass()->className +
                               " is no map");
    return map;
  });
}

std::shared_ptr<const CProbOctoMap> loadMap(const std::string& path, const BuildParams& params) {
  const CMetricMap::Ptr map = loadAnyMap(path, params);
  auto octomap = asProbOctoMap(CMetricMap::ConstPtr(map));
  if (!octomap)
    throw std::runtime_error(path + ": a " + map->GetRuntimeClass()->className +
                             " is not, and holds no, 3-D occupancy map");
  return octomap;
}

std::vector<CObservationLocalMap::Ptr> loadLocalMaps(const std::string& path) {
  return withPath(path, [&]() -> std::vector<CObservationLocalMap::Ptr> {
    if (isOcTreeFile(beginningOf(path)) || !isRecording(*firstObject(path))) return {};
    return latestMaps(path);
  });
}

namespace {

void saveBytes(std::string_view bytes, const std::string& path) {
  const std::string extension = mrpt::system::extractFileExtension(path);
  if (extension == "gz" || extension == "3Dscene")
    writeFileAtomically(path, gzCompressed(bytes));
  else
    writeFileAtomically(path, bytes);
}

std::string_view bytesOf(mrpt::io::CMemoryStream& memory) {
  return {static_cast<const char*>(memory.getRawBufferData()),
          static_cast<size_t>(memory.getTotalBytesCount())};
}

}  // namespace

void saveObject(const CSerializable& object, const std::string& path) {
  mrpt::io::CMemoryStream memory;
  mrpt::serialization::archiveFrom(memory) << object;
  saveBytes(bytesOf(memory), path);
}

void saveLocalMaps(const std::vector<CObservationLocalMap::Ptr>& maps, const std::string& path) {
  mrpt::io::CMemoryStream memory;
  auto archive = mrpt::serialization::archiveFrom(memory);
  for (const auto& map : maps) archive << *map;
  saveBytes(bytesOf(memory), path);
}

void saveMap(const CMetricMap& map, const std::string& path) {
  const std::string extension = mrpt::system::extractFileExtension(path);
  if (extension == "ot" || extension == "bt") {
    const auto octomap = asProbOctoMap(map);
    if (!octomap)
      throw std::runtime_error(path + ": a " + map.GetRuntimeClass()->className +
                               " cannot be saved as an octree");
    octomap->saveToOcTreeFile(path);
  } else {
    saveObject(map, path);
  }
}

}  // namespace mrpt::fusion
