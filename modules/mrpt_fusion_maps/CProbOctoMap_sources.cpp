// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * CProbOctoMap: the sources of a fused map. */

#include <stdexcept>

#include "fusion_octree/voxel_hash.h"
#include "mrpt_fusion_maps/archives/blobs.h"
#include "mrpt_fusion_maps/archives/sources.h"

using namespace mrpt::fusion;
using mrpt::maps::CProbOctoMap;

Sources CProbOctoMap::sources() const {
  Sources sources = m_sources;
  if (sources.empty()) return sources;
  const uint64_t hash = voxelHash(*m_octree);
  if (hash != m_sources_hash) sources.push_back({{}, {}, 0, hash});
  return sources;
}

void CProbOctoMap::setSources(Sources sources) {
  if (sources.size() > kMostSources) throw std::length_error("a map has too many sources");
  const uint64_t hash = voxelHash(*m_octree);
  for (SourceId& s : sources) {
    s.robot.resize(std::min(s.robot.size(), kMostSourceName));
    s.map.resize(std::min(s.map.size(), kMostSourceName));
    if (s.content_hash == 0) s.content_hash = hash;
  }
  m_sources = std::move(sources);
  m_sources_hash = hash;
}

namespace mrpt::fusion {
namespace {

std::string readName(mrpt::serialization::CArchive& in) {
  const auto size = in.ReadAs<uint64_t>();
  if (size > kMostSourceName) THROW_EXCEPTION("corrupt stream: a name is too long");
  return readBytes(in, size);
}

}  // namespace

void SourcesOfMap::copy(const CProbOctoMap& from, CProbOctoMap& to) {
  to.m_sources = from.m_sources;
  to.m_sources_hash = from.m_sources_hash;
}

void SourcesOfMap::write(mrpt::serialization::CArchive& out, const CProbOctoMap& map) {
  out << map.m_sources_hash << static_cast<uint32_t>(map.m_sources.size());
  for (const SourceId& s : map.m_sources) {
    writeBlob(out, s.robot);
    writeBlob(out, s.map);
    out << s.sequence << s.content_hash;
  }
}

void SourcesOfMap::read(mrpt::serialization::CArchive& in, CProbOctoMap& map) {
  in >> map.m_sources_hash;
  const auto n = in.ReadAs<uint32_t>();
  if (n > kMostSources) THROW_EXCEPTION("corrupt stream: there are too many sources");
  map.m_sources.clear();
  for (uint32_t i = 0; i < n; i++) {
    SourceId s;
    s.robot = readName(in);
    s.map = readName(in);
    in >> s.sequence >> s.content_hash;
    map.m_sources.push_back(std::move(s));
  }
}

}  // namespace mrpt::fusion
