// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Draws two maps from above. */

#include "fusion_report/top_view.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>

#include "fusion_report/font.h"

namespace mrpt::fusion {
namespace {

constexpr int kMargin = 30;       // width of the margin around a panel, pixels; the title is in it
constexpr int kGap = 8;           // width of the gap between bar and legend, pixels
constexpr int kPanelWidth = 900;  // approximate width of a panel, pixels

/** The number of voxels above each cell of a floor plan. */
struct Plan {
  Eigen::Vector2d low;
  double cell;
  int width, height;
  std::vector<float> count;

  Plan(const Eigen::Vector2d& lower, const Eigen::Vector2d& upper, double cell_size)
      : low(lower), cell(cell_size) {
    width = static_cast<int>((upper.x() - lower.x()) / cell) + 1;
    height = static_cast<int>((upper.y() - lower.y()) / cell) + 1;
    count.assign(static_cast<size_t>(width) * static_cast<size_t>(height), 0);
  }
  void add(const OccupiedVoxels& voxels, const Eigen::Isometry3d& T) {
    for (const auto& c : voxels.centre) {
      const Eigen::Vector3d p = T * c.cast<double>();
      const int x = static_cast<int>((p.x() - low.x()) / cell);
      const int y = static_cast<int>((p.y() - low.y()) / cell);
      if (x >= 0 && x < width && y >= 0 && y < height) count[index(x, y)]++;
    }
  }
  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
  }
  /** Strength of the colour of a cell: 0 without voxels, 1 for a column from floor to ceiling. */
  double strength(int x, int y) const {
    constexpr double kOneVoxel = 0.2;   // strength of a column of one voxel
    constexpr double kFullColumn = 12;  // number of voxels with the full strength, less one
    const double n = count[index(x, y)];
    return n > 0 ? kOneVoxel + (1 - kOneVoxel) * std::min(1.0, (n - 1) / kFullColumn) : 0;
  }
};

/** Mixes the colours of both maps on white paper. \param[in] a,b Strengths, [0,1]. */
Colour blend(double a, double b) {
  // Each map absorbs light: A leaves orange, B leaves blue.
  const auto channel = [](double keep_a, double a_strength, double keep_b, double b_strength) {
    return static_cast<uint8_t>(255 * (1 - (1 - keep_a) * a_strength) *
                                (1 - (1 - keep_b) * b_strength));
  };
  return {channel(0.90, a, 0.0, b), channel(0.55, a, 0.45, b), channel(0.0, a, 0.80, b)};
}

/** Extends a rectangle by the voxels of a map. */
void extend(const OccupiedVoxels& voxels, const Eigen::Isometry3d& T, Eigen::Vector2d& low,
            Eigen::Vector2d& high) {
  for (const auto& c : voxels.centre) {
    const Eigen::Vector2d p = (T * c.cast<double>()).head<2>();
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
}

/** Returns the length of the bar in a picture of a width, m: 5, 1, 0.5, 0.1, ... */
double barLengthFor(double width) {
  constexpr double kLongest = 5, kShortest = 0.001;
  double length = kLongest;
  for (bool by_five = true; length > width && length > kShortest; by_five = !by_five)
    length /= by_five ? 5 : 2;
  return length;
}

}  // namespace

Image drawTopView(const OccupiedVoxels& a, const OccupiedVoxels& b,
                  const std::vector<TopViewPanel>& panels) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Eigen::Vector2d low(kInfinity, kInfinity), high(-kInfinity, -kInfinity);
  extend(a, Eigen::Isometry3d::Identity(), low, high);
  for (const auto& panel : panels) extend(b, panel.T_a_b, low, high);
  const Eigen::Vector2d size = high - low;
  // A cell is as large as a voxel. It is larger if the picture would become too large.
  const double cell = std::max({a.resolution, b.resolution, size.maxCoeff() / kPanelWidth});
  constexpr double kMaxZoom = 8;  // pixels per cell; also for a map of one column, whose size is 0
  const int zoom =
      static_cast<int>(std::clamp(kPanelWidth * cell / size.maxCoeff(), 1.0, kMaxZoom));

  const Plan empty(low, high, cell);
  const int w = empty.width * zoom, h = empty.height * zoom;
  const bool stacked = w > h;  // wide panels are below each other, tall panels are side by side
  const int n = static_cast<int>(panels.size());
  const double bar_length = barLengthFor(w * cell / zoom);
  const int bar = static_cast<int>(bar_length / cell * zoom);
  char legend[80];
  std::snprintf(legend, sizeof(legend), "%g m     A: orange   B: blue   both: black", bar_length);
  const auto textWidth = [](const std::string& text) {
    return kGlyphWidth * static_cast<int>(text.size());
  };
  int panel_width = w;  // with its title
  for (const auto& panel : panels) panel_width = std::max(panel_width, textWidth(panel.title));
  const int width = stacked ? panel_width : n * (panel_width + kMargin);
  Image image(std::max(width, bar + kGap + textWidth(legend)) + 2 * kMargin,
              (stacked ? n * (h + kMargin) : h) + 2 * kMargin);

  for (int i = 0; i < n; i++) {
    Plan plan_a(empty), plan_b(empty);
    plan_a.add(a, Eigen::Isometry3d::Identity());
    plan_b.add(b, panels[static_cast<size_t>(i)].T_a_b);
    const int x0 = kMargin + (stacked ? 0 : i * (panel_width + kMargin));
    const int y0 = kMargin + (stacked ? i * (h + kMargin) : 0);
    for (int y = 0; y < plan_a.height; y++)
      for (int x = 0; x < plan_a.width; x++) {
        const double in_a = plan_a.strength(x, y), in_b = plan_b.strength(x, y);
        if (in_a <= 0 && in_b <= 0) continue;
        const int px = x0 + x * zoom, py = y0 + h - (y + 1) * zoom;
        image.fillRectangle(px, py, px + zoom - 1, py + zoom - 1, blend(in_a, in_b));
      }
    image.drawText(x0, y0 - 20, panels[static_cast<size_t>(i)].title, kBlack);
  }
  const int bottom = image.height() - 12;
  image.fillRectangle(kMargin, bottom, kMargin + bar, bottom + 3, kBlack);
  image.drawText(kMargin + bar + kGap, bottom - 8, legend, kBlack);
  return image;
}

}  // namespace mrpt::fusion
