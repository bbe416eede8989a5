// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Draws the result of a fusion as a 3-D scene. */

#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/fusion_scene.h>
#include <mrpt/fusion/poses.h>
#include <mrpt/maps/CEdgeVoxelMap.h>

#include <cmath>

using namespace mrpt::fusion;
using mrpt::img::TColor;
using mrpt::poses::CPose3D;
using viz::COctoMapVoxels;
using viz::CSetOfLines;

namespace {

constexpr TColor kOrange{230, 140, 30}, kBlue{50, 110, 220}, kBlack{20, 20, 20}, kRed{220, 30, 30};

mrpt::math::TPoint3Df toPoint(const Eigen::Vector3f& p) { return {p.x(), p.y(), p.z()}; }

/** Draws voxels as cubes. Their colour depends on their probability. */
template <class ColourOf>
COctoMapVoxels::Ptr drawVoxels(const char* name, const OccupiedVoxels& voxels,
                               ColourOf&& colourOf) {
  auto cubes = COctoMapVoxels::Create();
  cubes->setName(name);
  cubes->resizeVoxelSets(1);
  cubes->reserveVoxels(0, voxels.size());
  Eigen::Vector3f low = Eigen::Vector3f::Zero(), high = low;
  for (size_t i = 0; i < voxels.size(); i++) {
    const Eigen::Vector3f& centre = voxels.centre[i];
    low = i == 0 ? centre : low.cwiseMin(centre).eval();
    high = i == 0 ? centre : high.cwiseMax(centre).eval();
    cubes->push_back_Voxel(
        0, COctoMapVoxels::TVoxel(toPoint(centre), voxels.resolution,
                                  colourOf(static_cast<double>(voxels.probability[i]))));
  }
  cubes->setBoundingBox(toPoint(low), toPoint(high));
  cubes->showVoxels(0, true);
  return cubes;
}

CSetOfLines::Ptr drawLines(const char* name, const TColor& colour) {
  auto lines = CSetOfLines::Create();
  lines->setName(name);
  lines->setColor_u8(colour);
  return lines;
}

viz::CSetOfObjects::Ptr drawEdges(const char* name, const EdgeVoxels& edges) {
  auto set = viz::CSetOfObjects::Create();
  set->setName(name);
  if (edges.size() > 0) mrpt::maps::CEdgeVoxelMap(edges).getVisualizationInto(*set);
  return set;
}

void drawPairs(const FusionView& view, const OccupiedVoxels& a, const OccupiedVoxels& b,
               Scene& scene) {
  auto inliers = drawLines("inliers", kBlack), outliers = drawLines("outliers", kRed);
  const Eigen::Isometry3d T_a_b = toEigen(view.pose);
  for (const Pair& pair : view.pairs) {
    const double p_a = a.probability[pair.a], p_b = b.probability[pair.b];
    const bool is_inlier =
        mahalanobisDistance(pair.squared_distance, p_a, p_b) < view.inlier_mahalanobis;
    const Eigen::Vector3d from = a.centre[pair.a].cast<double>();
    const Eigen::Vector3d to = T_a_b * b.centre[pair.b].cast<double>();
    (is_inlier ? inliers : outliers)
        ->appendLine(from.x(), from.y(), from.z(), to.x(), to.y(), to.z());
  }
  scene.insert(inliers);
  scene.insert(outliers);
}

}  // namespace

Scene::Ptr mrpt::fusion::drawFusion(const FusionView& view) {
  auto scene = Scene::Create();
  const OccupiedVoxels a = extractOccupiedVoxels(view.a), b = extractOccupiedVoxels(view.b);
  scene->insert(drawVoxels("map A", a, [](double) { return kOrange; }));
  scene->insert(drawEdges("edges A", view.edges_a));
  const auto of_b = {
      std::static_pointer_cast<viz::CRenderizable>(
          drawVoxels("map B", b, [](double) { return kBlue; })),
      std::static_pointer_cast<viz::CRenderizable>(drawEdges("edges B", view.edges_b))};
  for (const auto& object : of_b) {
    object->setPose(view.pose);
    scene->insert(object);
  }
  drawPairs(view, a, b, *scene);
  if (view.fused) {
    auto fused = drawVoxels("fused map", extractOccupiedVoxels(*view.fused), [](double p) {
      const auto grey = static_cast<uint8_t>(std::lround(60 + 180 * (2 * p - 1)));
      return TColor(grey, grey, grey);
    });
    const auto box = fused->getBoundingBox();
    constexpr double kGap = 2;  // m
    fused->setPose(CPose3D(0, -(box.max.y - box.min.y + kGap), 0, 0, 0, 0));
    scene->insert(fused);
  }
  return scene;
}
