// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * CProbOctoMap: octree files and 3-D drawings of the map. */

#include <mrpt/fusion/compat.h>
#include <mrpt/maps/CProbOctoMap.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "fusion_base/error_text.h"
#include "fusion_base/files.h"
#include "fusion_octree/files.h"

using namespace mrpt::fusion;
using namespace mrpt::maps;

void CProbOctoMap::loadFromOcTreeFile(const std::string& path) {
  withPath(path, [&] { setOctree(parseOcTreeFile(readFileBytes(path))); });
}

void CProbOctoMap::saveToOcTreeFile(const std::string& path) const { saveOcTree(*m_octree, path); }

void CProbOctoMap::loadFromOcTreeBytes(std::string_view bytes, double resolution) {
  auto tree = isOcTreeFile(bytes) || resolution <= 0 ? parseOcTreeFile(bytes)
                                                     : parseRawOcTree(bytes, resolution);
  if (!tree) throw std::runtime_error("the bytes are not the nodes of an octree");
  setOctree(std::move(tree));
}

std::string CProbOctoMap::toOtBytes() const { return toOtFile(*m_octree); }

std::string CProbOctoMap::toBtBytes() const { return toBtFile(*m_octree); }

void CProbOctoMap::saveMetricMapRepresentationToFile(const std::string& filNamePrefix) const {
  Scene scene;
  auto objects = viz::CSetOfObjects::Create();
  getVisualizationInto(*objects);
  scene.insert(objects);
  const std::string path = filNamePrefix + "_3D.3Dscene";
  if (!scene.saveToFile(path)) throw std::runtime_error(path + ": cannot be written");
  saveToOcTreeFile(filNamePrefix + ".ot");
}

void CProbOctoMap::getVisualizationInto(viz::CSetOfObjects& o) const {
  if (!genericMapParams.enableSaveAs3DObject) return;
  auto voxels = viz::COctoMapVoxels::Create();
  getAsOctoMapVoxels(*voxels);
  o.insert(voxels);
}

void CProbOctoMap::getAsOctoMapVoxels(viz::COctoMapVoxels& gl) const {
  using viz::COctoMapVoxels;
  double x_min, y_min, z_min, x_max, y_max, z_max;
  getMetricMin(x_min, y_min, z_min);
  getMetricMax(x_max, y_max, z_max);
  const double height = z_max - z_min + 0.01;
  const mrpt::img::TColorf base = gl.getColor();

  // Returns the colour of a voxel by the colouring scheme of the object.
  const auto colour = [&](double z, double occupancy) {
    const double by_height = (z - z_min) / height;
    const double by_occupancy = (240 * (1 - occupancy) + 15) / 255;
    const double opacity = std::max(0.0, 1 - 2 * (1 - occupancy));
    double brightness = 1, alpha = base.A;
    switch (gl.getVisualizationMode()) {
      case COctoMapVoxels::FIXED:
        break;
      case COctoMapVoxels::COLOR_FROM_HEIGHT:
        brightness = by_height;
        break;
      case COctoMapVoxels::COLOR_FROM_OCCUPANCY:
        brightness = by_occupancy;
        break;
      case COctoMapVoxels::TRANSPARENCY_FROM_OCCUPANCY:
        alpha = opacity;
        break;
      case COctoMapVoxels::TRANS_AND_COLOR_FROM_OCCUPANCY:
        brightness = by_occupancy;
        alpha = 50.0 / 255;
        break;
      case COctoMapVoxels::MIXED:
        brightness = by_height;
        alpha = opacity;
        break;
      default:
        THROW_EXCEPTION("Unknown colouring scheme of COctoMapVoxels");
    }
    const auto byte = [](double v) { return static_cast<uint8_t>(255 * v); };
    return mrpt::img::TColor(byte(brightness * base.R), byte(brightness * base.G),
                             byte(brightness * base.B), byte(alpha));
  };

  gl.clear();
  gl.resizeVoxelSets(2);
  gl.showVoxels(viz::VOXEL_SET_OCCUPIED, renderingOptions.visibleOccupiedVoxels);
  gl.showVoxels(viz::VOXEL_SET_FREESPACE, renderingOptions.visibleFreeVoxels);
  for (auto it = m_octree->begin_tree(); it != m_octree->end_tree(); ++it) {
    const mrpt::math::TPoint3D centre(it.getX(), it.getY(), it.getZ());
    if (it.isLeaf()) {
      const bool occupied = m_octree->isNodeOccupied(*it);
      if (occupied ? renderingOptions.generateOccupiedVoxels : renderingOptions.generateFreeVoxels)
        gl.push_back_Voxel(occupied ? viz::VOXEL_SET_OCCUPIED : viz::VOXEL_SET_FREESPACE,
                           COctoMapVoxels::TVoxel(centre.cast<float>(), it.getSize(),
                                                  colour(centre.z, it->getOccupancy())));
    } else if (renderingOptions.generateGridLines) {
      const double half = 0.5 * it.getSize();
      const mrpt::math::TPoint3D corner(half, half, half);
      gl.push_back_GridCube(COctoMapVoxels::TGridCube((centre - corner).cast<float>(),
                                                      (centre + corner).cast<float>()));
    }
  }
  if (gl.isCubeTransparencyEnabled()) gl.sort_voxels_by_z();
  gl.setBoundingBox({x_min, y_min, z_min}, {x_max, y_max, z_max});
}
