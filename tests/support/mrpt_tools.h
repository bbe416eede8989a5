// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/serialization/CArchive.h>

#include "support/tree_tools.h"

/** \file
 * What several test files need: see tree_tools.h; and MRPT's ways to look at a map. */

namespace map_tests {

/** The occupancy of each finest voxel as the map itself answers for it. MRPT's COctoMap shows its
 * tree only through what it draws, so that is what says where to ask; all of it must be drawn. */
template <class Map>
std::map<VoxelIndex, double> occupanciesOf(const Map& map) {
  mrpt::opengl::COctoMapVoxels drawn;
  map.getAsOctoMapVoxels(drawn);
  std::map<VoxelIndex, double> voxels;
  const double res = map.getResolution();
  for (size_t set = 0; set < drawn.getVoxelSetCount(); set++)
    for (size_t i = 0; i < drawn.getVoxelCount(set); i++) {
      const auto& v = drawn.getVoxel(set, i);
      const auto side = static_cast<int>(std::lround(v.side_length / res));
      const auto low = [&](float centre) {
        return static_cast<int>(std::lround(centre / res - 0.5 * side));
      };
      for (int x = 0; x < side; x++)
        for (int y = 0; y < side; y++)
          for (int z = 0; z < side; z++) {
            const VoxelIndex k{low(v.coords.x) + x, low(v.coords.y) + y, low(v.coords.z) + z};
            const auto centre = [&](int axis) { return static_cast<float>((k[axis] + 0.5) * res); };
            double p = -1;
            EXPECT_TRUE(map.getPointOccupancy(centre(0), centre(1), centre(2), p));
            voxels[k] = p;
          }
    }
  return voxels;
}

/** The bytes of an object in MRPT's serialization. */
inline std::string serialized(const mrpt::serialization::CSerializable& object) {
  mrpt::io::CMemoryStream memory;
  mrpt::serialization::archiveFrom(memory) << object;
  return {static_cast<const char*>(memory.getRawBufferData()),
          static_cast<size_t>(memory.getTotalBytesCount())};
}

/** Reads an object of unknown class. */
inline mrpt::serialization::CSerializable::Ptr deserialized(std::string_view bytes) {
  mrpt::io::CMemoryStream memory;
  memory.assignMemoryNotOwn(bytes.data(), bytes.size());
  return mrpt::serialization::archiveFrom(memory).ReadObject();
}

/** Reads an object into one that exists. */
inline void deserializeInto(std::string_view bytes, mrpt::serialization::CSerializable& object) {
  mrpt::io::CMemoryStream memory;
  memory.assignMemoryNotOwn(bytes.data(), bytes.size());
  mrpt::serialization::archiveFrom(memory) >> object;
}

}  // namespace map_tests
