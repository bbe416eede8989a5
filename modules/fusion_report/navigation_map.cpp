// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Writes slices of maps for navigation. */

#include "fusion_report/navigation_map.h"

#include <cstdio>

#include "fusion_report/quoted.h"

namespace mrpt::fusion {
namespace {

/** Returns the grey of a cell. A map server computes (255 - grey) / 255 and compares it with the
 * thresholds of toMapYaml(). */
char greyOf(CellKind kind) {
  switch (kind) {
    case CellKind::Occupied:
      return '\0';
    case CellKind::Free:
      return static_cast<char>(254);
    case CellKind::Unknown:
      break;
  }
  return static_cast<char>(205);
}

}  // namespace

std::string toPgm(const MapSlice& slice, const CellThresholds& thresholds) {
  char header[80];
  std::snprintf(header, sizeof(header), "P5\n%zu %zu\n255\n", slice.width, slice.height);
  std::string pgm = header;
  pgm.reserve(pgm.size() + slice.log_odds.size());
  for (size_t row = slice.height; row-- > 0;)
    for (size_t x = 0; x < slice.width; x++)
      pgm += greyOf(thresholds.kindOf(slice.log_odds[row * slice.width + x]));
  return pgm;
}

std::string toMapYaml(const MapSlice& slice, const std::string& image) {
  char place[160];
  std::snprintf(place, sizeof(place), "resolution: %.9g\norigin: [%.9g, %.9g, 0]\n",
                slice.resolution, slice.low_x, slice.low_y);
  return "image: " + quoted(image) + "\nmode: trinary\n" + place +
         "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
}

}  // namespace mrpt::fusion
