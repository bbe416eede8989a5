// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/serialization/CArchive.h>

#include "support/tree_tools.h"

/** \file
 * Inspection of maps through MRPT, and serialization. See also tree_tools.h. */

namespace map_tests {

/** Returns the occupancy of each finest voxel from the map's getPointOccupancy(). COctoMap gives
 * access to its octree only by drawing, so the drawn voxels define the query points. The drawing
 * must include all voxels. */
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

/** Returns the bytes of an object in MRPT's serialization. */
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

/** Reads an object into an existing object. */
inline void deserializeInto(std::string_view bytes, mrpt::serialization::CSerializable& object) {
  mrpt::io::CMemoryStream memory;
  memory.assignMemoryNotOwn(bytes.data(), bytes.size());
  mrpt::serialization::archiveFrom(memory) >> object;
}

}  // namespace map_tests
