// SPDX-License-Identifier: BSD-3-Clause
#include "top_view.h"

#include <mrpt/img/CImage.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "fusion_base/files.h"
#include "fusion_octree/files.h"

using mrpt::fusion::OccupiedVoxels;
using mrpt::img::TColor;

namespace {

constexpr int kMargin = 30;       // pixels around a panel, with room for its title
constexpr int kPanelWidth = 900;  // pixels, about

/** An image as a PNG file: MRPT writes one to a file only, here one beside where it is to be, but
 * for devices. */
std::string pngOf(const mrpt::img::CImage& image, const std::string& path) {
  namespace fs = std::filesystem;
  const bool is_device = fs::exists(path) && !fs::is_regular_file(path);
  std::string name =
      (is_device ? (fs::temp_directory_path() / "view").string() : path) + ".XXXXXX.png";
  const auto check = [&](bool done) {
    if (!done) throw std::runtime_error(path + ": cannot be written");
  };
  const int fd = ::mkstemps(name.data(), 4);
  check(fd >= 0);
  ::close(fd);
  const std::shared_ptr<void> removed(nullptr, [&](void*) { ::unlink(name.c_str()); });
  check(image.saveToFile(name));
  return mrpt::fusion::readFileBytes(name);
}

/** How many voxels stand over each cell of the plan. */
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
  /** 0 (nothing) to 1 (a column of voxels from floor to ceiling). */
  double strength(int x, int y) const {
    constexpr double kFloor = 0.2, kFullColumn = 12;
    const double n = count[index(x, y)];
    return n > 0 ? kFloor + (1 - kFloor) * std::min(1.0, (n - 1) / kFullColumn) : 0;
  }
};

TColor blend(double a, double b) {
  // Each map takes away the colours that are not its own: A leaves orange, B leaves blue.
  const auto channel = [](double keep_a, double a_strength, double keep_b, double b_strength) {
    return static_cast<uint8_t>(255 * (1 - (1 - keep_a) * a_strength) *
                                (1 - (1 - keep_b) * b_strength));
  };
  return {channel(0.90, a, 0.0, b), channel(0.55, a, 0.45, b), channel(0.0, a, 0.80, b)};
}

void extend(const OccupiedVoxels& voxels, const Eigen::Isometry3d& T, Eigen::Vector2d& low,
            Eigen::Vector2d& high) {
  for (const auto& c : voxels.centre) {
    const Eigen::Vector2d p = (T * c.cast<double>()).head<2>();
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
}

}  // namespace

void drawTopView(const OccupiedVoxels& a, const OccupiedVoxels& b,
                 const std::vector<TopViewPanel>& panels, const std::string& path) {
  constexpr double kFar = 1e9;
  Eigen::Vector2d low(kFar, kFar), high(-kFar, -kFar);
  extend(a, Eigen::Isometry3d::Identity(), low, high);
  for (const auto& panel : panels) extend(b, panel.T_a_b, low, high);
  const Eigen::Vector2d size = high - low;
  // Cells of a voxel, or larger where the picture would not fit.
  const double cell = std::max({a.resolution, b.resolution, size.maxCoeff() / kPanelWidth});
  const int zoom = std::clamp(static_cast<int>(kPanelWidth * cell / size.maxCoeff()), 1, 8);

  const Plan empty(low, high, cell);
  const int w = empty.width * zoom, h = empty.height * zoom;
  const bool stacked = w > h;  // wide maps below each other, tall ones side by side
  const int n = static_cast<int>(panels.size());
  mrpt::img::CImage image((stacked ? w : n * (w + kMargin)) + 2 * kMargin,
                          (stacked ? n * (h + kMargin) : h) + 2 * kMargin, mrpt::img::CH_RGB);
  image.filledRectangle(0, 0, static_cast<int>(image.getWidth()) - 1,
                        static_cast<int>(image.getHeight()) - 1, TColor::white());

  for (int i = 0; i < n; i++) {
    Plan plan_a(empty), plan_b(empty);
    plan_a.add(a, Eigen::Isometry3d::Identity());
    plan_b.add(b, panels[static_cast<size_t>(i)].T_a_b);
    const int x0 = kMargin + (stacked ? 0 : i * (w + kMargin));
    const int y0 = kMargin + (stacked ? i * (h + kMargin) : 0);
    for (int y = 0; y < plan_a.height; y++)
      for (int x = 0; x < plan_a.width; x++) {
        const double in_a = plan_a.strength(x, y), in_b = plan_b.strength(x, y);
        if (in_a <= 0 && in_b <= 0) continue;
        const int px = x0 + x * zoom, py = y0 + h - (y + 1) * zoom;
        image.filledRectangle(px, py, px + zoom - 1, py + zoom - 1, blend(in_a, in_b));
      }
    image.textOut(x0, y0 - 20, panels[static_cast<size_t>(i)].title, TColor::black());
  }
  const int bar = static_cast<int>(5.0 / cell * zoom);
  const int bottom = static_cast<int>(image.getHeight()) - 12;
  image.filledRectangle(kMargin, bottom, kMargin + bar, bottom + 3, TColor::black());
  image.textOut(kMargin + bar + 8, bottom - 8, "5 m     A: orange   B: blue   both: black",
                TColor::black());

  mrpt::fusion::writeFileAtomically(path, pngOf(image, path));
}
