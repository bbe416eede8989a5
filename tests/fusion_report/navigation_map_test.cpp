// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of slices as files of map servers. The files are read as nav2_map_server reads them. */
#include "fusion_report/navigation_map.h"

#include <gtest/gtest.h>

#include <string>

namespace mrpt::fusion {
namespace {

/** A slice of 3 x 2 cells: occupied, free, unknown; then unknown, occupied, free. */
MapSlice smallSlice() {
  MapSlice slice;
  slice.resolution = 0.05;
  slice.low_x = -1.25;
  slice.low_y = 7.1;
  slice.width = 3;
  slice.height = 2;
  slice.log_odds = {2, -2, MapSlice::kUnknown, MapSlice::kUnknown, 0.1F, -0.1F};
  return slice;
}

/** Returns how a map server reads a grey: 100 occupied, 0 free, -1 unknown. */
int cellOf(char grey) {
  const double occupied = (255.0 - static_cast<unsigned char>(grey)) / 255.0;
  if (occupied > 0.65) return 100;
  return occupied < 0.196 ? 0 : -1;
}

TEST(NavigationMap, HasTheHighestRowFirst) {
  const std::string pgm = toPgm(smallSlice(), {0, 0});
  const std::string header = "P5\n3 2\n255\n";
  ASSERT_EQ(pgm.substr(0, header.size()), header);
  ASSERT_EQ(pgm.size(), header.size() + 6);
  std::vector<int> cells;
  for (const char grey : pgm.substr(header.size())) cells.push_back(cellOf(grey));
  EXPECT_EQ(cells, (std::vector<int>{-1, 100, 0, 100, 0, -1}));
}

TEST(NavigationMap, KeepsCellsBetweenTheThresholdsUnknown) {
  const std::string pgm = toPgm(smallSlice(), {-1, 1});
  EXPECT_EQ(cellOf(pgm[pgm.size() - 6 + 1]), -1);
  EXPECT_EQ(cellOf(pgm[pgm.size() - 6 + 2]), -1);
  EXPECT_EQ(cellOf(pgm[pgm.size() - 6 + 3]), 100);
  EXPECT_EQ(cellOf(pgm[pgm.size() - 6 + 4]), 0);
}

TEST(NavigationMap, StatesPlaceAndThresholds) {
  EXPECT_EQ(toMapYaml(smallSlice(), "floor \"2\".pgm"),
            "image: \"floor \\\"2\\\".pgm\"\nmode: trinary\nresolution: 0.05\n"
            "origin: [-1.25, 7.1, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
}

}  // namespace
}  // namespace mrpt::fusion
