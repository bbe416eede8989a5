// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads serialized maps. Checks what MRPT does not check. */

#include "mrpt_fusion_maps/archives/map_reader.h"

#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CColouredOctoMap.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/COctoMap.h>
#include <mrpt/rtti/CObject.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "fusion_octree/files.h"
#include "mrpt_fusion_maps/archives/blobs.h"
#include "mrpt_fusion_maps/archives/flags.h"

using mrpt::maps::CColouredOctoMap;
using mrpt::maps::CMetricMap;
using mrpt::maps::CMultiMetricMap;
using mrpt::maps::COctoMap;

namespace mrpt::fusion {
namespace {

constexpr unsigned kMostDepth = 8;  // of sets of maps

CMetricMap::Ptr readMapAt(unsigned depth, GuardedArchive& in, const ObjectHeader& header);

/** Reads a set of maps. MRPT creates as many maps as the stream claims before it reads them, and
 * reads objects that are not maps as null. */
void readSet(unsigned depth, GuardedArchive& in, const ObjectHeader& header, CMultiMetricMap& set) {
  if (depth == kMostDepth) throw ReadingStopped("too many sets of maps within each other");
  if (header.version == 11) in.ReadAs<uint32_t>();  // a number that later versions do not have
  const auto count = in.ReadAs<uint32_t>();
  for (uint32_t i = 0; i < count; i++) {
    const ObjectHeader next = in.readHeader();
    if (!isMap(next)) throw ReadingStopped("an object in a set of maps is no map");
    set.maps.push_back(readMapAt(depth + 1, in, next));
  }
}

/** An archive that keeps the bytes that are read from another archive. */
class Recorder : public mrpt::serialization::CArchive {
 public:
  explicit Recorder(mrpt::serialization::CArchive& in) : in_(in) {}
  const std::string& bytes() const { return bytes_; }

 protected:
  size_t read(void* buffer, size_t count) override {
    const size_t n = in_.ReadBuffer(buffer, count);
    bytes_.append(static_cast<const char*>(buffer), n);
    return n;
  }
  size_t write(const void*, size_t) override { THROW_EXCEPTION("the archive is for reading only"); }

 private:
  mrpt::serialization::CArchive& in_;
  std::string bytes_;
};

/** Replaces a text in the header of an octree file, if it is there. */
void replaceInHeader(std::string& file, std::string_view text, std::string_view by) {
  const size_t at = file.find(text);
  if (at < file.find("\ndata\n")) file.replace(at, text.size(), by);
}

/** Reads the octree of a map and writes it again, so that OctoMap reads what OctoMap has written.
 * MRPT writes both classes in the binary format, without colours. */
std::string rewrittenOctree(std::string file, bool coloured) {
  constexpr std::string_view kPlain = "\nid OcTree\n", kColour = "\nid ColorOcTree\n";
  if (file.empty()) return file;
  replaceInHeader(file, kColour, kPlain);
  std::string rewritten = toBtFile(*parseOcTreeFile(file));
  if (coloured) replaceInHeader(rewritten, kPlain, kColour);
  return rewritten;
}

/** Reads an octomap of MRPT. */
template <class Map>
void readOctoMap(GuardedArchive& in, const ObjectHeader& header, Map& map) {
  Recorder recorder(in);
  map.likelihoodOptions.readFromStream(recorder);
  map.renderingOptions.readFromStream(recorder);
  recorder >> map.genericMapParams;
  checkFlags(map.renderingOptions);

  const std::string octree =
      rewrittenOctree(readBytes(in, in.ReadAs<uint32_t>()), std::is_same_v<Map, CColouredOctoMap>);
  mrpt::io::CMemoryStream memory;
  auto out = mrpt::serialization::archiveFrom(memory);
  out.WriteBuffer(recorder.bytes().data(), recorder.bytes().size());
  out << octree;
  if (!header.is_old) out << kObjectEnd;
  memory.Seek(0);
  GuardedArchive(memory, in.budget()).readBody(&map, header);
}

/** Reads an object as one of the classes whose readers in MRPT trust the stream.
 * \return False if the class is another. */
bool readChecked(unsigned depth, GuardedArchive& in, const ObjectHeader& header, CMetricMap& map) {
  constexpr int kSetVersions[] = {11, 12}, kOctoMapVersion = 3;
  if (auto* set = dynamic_cast<CMultiMetricMap*>(&map);
      set && (header.version == kSetVersions[0] || header.version == kSetVersions[1]))
    readSet(depth, in, header, *set);
  else if (auto* octomap = dynamic_cast<COctoMap*>(&map);
           octomap && header.version == kOctoMapVersion)
    readOctoMap(in, header, *octomap);
  else if (auto* coloured = dynamic_cast<CColouredOctoMap*>(&map);
           coloured && header.version == kOctoMapVersion)
    readOctoMap(in, header, *coloured);
  else
    return false;
  return true;
}

CMetricMap::Ptr readMapAt(unsigned depth, GuardedArchive& in, const ObjectHeader& header) {
  if (!isMap(header)) throw ReadingStopped("an object in it is not a map");
  auto map = std::dynamic_pointer_cast<CMetricMap>(
      mrpt::rtti::findRegisteredClass(header.class_name)->createObject());
  in.readBody(readChecked(depth, in, header, *map) ? nullptr : map.get(), header);
  checkFlags(map->genericMapParams);
  return map;
}

}  // namespace

bool isMap(const ObjectHeader& header) {
  const auto* id = mrpt::rtti::findRegisteredClass(header.class_name);
  return id && id->ptrCreateObject && id->derivedFrom(CLASS_ID(CMetricMap));
}

CMetricMap::Ptr readMap(GuardedArchive& in, const ObjectHeader& header) {
  return readMapAt(0, in, header);
}

}  // namespace mrpt::fusion
