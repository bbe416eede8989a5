// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the picture of two maps, and of its PNG file. */

#include "fusion_report/top_view.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

using namespace mrpt::fusion;

namespace {

OccupiedVoxels voxelsAt(const std::vector<Eigen::Vector3f>& centres) {
  OccupiedVoxels voxels;
  voxels.resolution = 0.1;
  voxels.centre.assign(centres.begin(), centres.end());
  voxels.probability.assign(centres.size(), 0.9F);
  return voxels;
}

Eigen::Isometry3d shiftBy(double x) { return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)); }

bool operator==(const Colour& a, const Colour& b) {
  return a.red == b.red && a.green == b.green && a.blue == b.blue;
}

/** Returns the number of pixels of a colour in the panel: the margin has text. */
int count(const Image& image, const Colour& colour) {
  constexpr int kMargin = 30;
  int n = 0;
  for (int y = kMargin; y < image.height() - kMargin; y++)
    for (int x = kMargin; x < image.width() - kMargin; x++) n += image.at(x, y) == colour ? 1 : 0;
  return n;
}

TEST(Image, CutsOffWhatIsOutside) {
  Image image(10, 20);
  image.fillRectangle(-5, -5, 2, 3, kBlack);
  image.fillRectangle(8, 18, 100, 100, kBlack);
  image.drawText(-4, 15, "MM", kBlack);
  int black = 0;
  for (int y = 0; y < 15; y++)
    for (int x = 0; x < 10; x++) black += image.at(x, y) == kBlack ? 1 : 0;
  EXPECT_EQ(black, 3 * 4);
  EXPECT_TRUE(image.at(9, 19) == kBlack);
  EXPECT_TRUE(image.at(9, 10) == kWhite);
}

TEST(Image, IsAPngOfItsSize) {
  const std::string png = Image(300, 7).toPng();
  ASSERT_GT(png.size(), 24U);
  EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
  const auto byte = [&](size_t i) { return static_cast<uint8_t>(png[i]); };
  EXPECT_EQ(byte(18) * 256 + byte(19), 300);
  EXPECT_EQ(byte(22) * 256 + byte(23), 7);
}

TEST(TopView, DrawsAOrangeBBlueAndBothDark) {
  const auto a = voxelsAt({{0.05F, 0.05F, 0}, {0.15F, 0.05F, 0}});
  const auto b = voxelsAt({{0.05F, 0.05F, 0}, {0.15F, 0.05F, 0}});
  const Image apart = drawTopView(a, b, {{"", shiftBy(0.2)}});
  const Image together = drawTopView(a, b, {{"", shiftBy(0)}});
  const Colour orange{249, 232, 204}, blue{204, 226, 244};
  EXPECT_GT(count(apart, orange), 0);
  EXPECT_EQ(count(apart, orange), count(apart, blue));
  EXPECT_EQ(count(together, orange) + count(together, blue), 0);
}

TEST(TopView, DrawsHighColumnsStronger) {
  std::vector<Eigen::Vector3f> wall;
  for (int i = 0; i < 20; i++) wall.emplace_back(0.05F, 0.05F, 0.1F * static_cast<float>(i));
  const Image image =
      drawTopView(voxelsAt(wall), voxelsAt({{1.05F, 0.05F, 0}}), {{"", shiftBy(0)}});
  EXPECT_GT(count(image, {229, 140, 0}), 0) << "full orange";
}

TEST(TopView, HasOnePanelForEachPose) {
  const auto a = voxelsAt({{0.05F, 0.05F, 0}, {8.05F, 9.05F, 0}});
  const Image one = drawTopView(a, a, {{"one", shiftBy(0)}});
  const Image two = drawTopView(a, a, {{"one", shiftBy(0)}, {"two", shiftBy(0)}});
  EXPECT_EQ(one.height(), two.height());
  EXPECT_GT(two.width(), one.width()) << "tall panels are side by side";
}

TEST(TopView, TakesMapsOfOneVoxel) {
  const auto voxel = voxelsAt({{0.05F, 0.05F, 0}});
  const Image image = drawTopView(voxel, voxel, {{"one voxel", shiftBy(0)}});
  EXPECT_GT(image.width(), 60);
}

TEST(TopView, IsWideEnoughForItsLegend) {
  const auto tall = voxelsAt({{0.05F, 0.05F, 0}, {0.05F, 30.05F, 0}, {4.05F, 0.05F, 0}});
  const Image wide = drawTopView(tall, tall, {{std::string(200, 'x'), shiftBy(0)}});
  const Image image = drawTopView(tall, tall, {{"", shiftBy(0)}});
  ASSERT_GT(wide.width(), image.width());
  const auto legendOf = [](const Image& i) {
    size_t black = 0;
    for (int y = i.height() - 28; y < i.height(); y++)
      for (int x = 0; x < i.width(); x++) black += i.at(x, y) == kBlack ? 1U : 0U;
    return black;
  };
  EXPECT_EQ(legendOf(image), legendOf(wide)) << "the legend is cut off";
}

TEST(TopView, TheBarIsNotLongerThanTheMaps) {
  auto small = voxelsAt({{0, 0, 0}, {0.99F, 0.5F, 0}});
  small.resolution = 0.01;
  const Image image = drawTopView(small, small, {{"", shiftBy(0)}});
  int longest = 0;
  for (int x = 0, run = 0; x < image.width(); x++) {
    run = image.at(x, image.height() - 11) == kBlack ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  EXPECT_GT(longest, image.width() / 4);
  EXPECT_LT(longest, image.width());
}

}  // namespace
