// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The report of a run as a value. */

#include "fusion_report/report.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "fusion_octree/walk.h"

namespace mrpt::fusion {

MapReport reportOn(const std::string& role, const std::string& path, const octomap::OcTree& map) {
  MapReport m;
  m.role = role;
  m.path = path;
  m.resolution = map.getResolution();
  m.nodes = map.size();
  if (map.size() > 0) {
    const Eigen::AlignedBox3d known = knownSpace(map);
    std::copy_n(known.min().data(), 3, m.low);
    std::copy_n(known.max().data(), 3, m.high);
  }
  m.statistics = statisticsOf(map);
  return m;
}

}  // namespace mrpt::fusion
