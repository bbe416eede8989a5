// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the readers of point clouds. */
#include "fusion_octree/point_clouds/point_cloud.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "support/cloud_files.h"
#include "support/gzip_bytes.h"
#include "support/tree_tools.h"

namespace mrpt::fusion {
namespace {

using map_tests::cloudFiles;
using map_tests::errorOf;
using map_tests::pcdFile;
using map_tests::pcdHeader;
using map_tests::plyFile;
using map_tests::Points;

Points somePoints(size_t count = 500) {
  std::mt19937 rng(3);
  std::uniform_real_distribution<float> place(-20, 20);
  Points points;
  for (size_t i = 0; i < count; i++) {
    const float x = place(rng), y = place(rng);
    points.emplace_back(x, y, place(rng));
  }
  return points;
}

std::string reasonOf(const std::string& bytes) {
  return errorOf([&] { parsePointCloud(bytes); });
}

TEST(PointCloud, IsReadFromAllFormats) {
  const Points points = somePoints();
  for (const auto& file : cloudFiles(points)) {
    EXPECT_TRUE(isPointCloudFile(file.bytes.substr(0, 64))) << file.name;
    for (const std::string& bytes : {file.bytes, map_tests::gzipped(file.bytes)}) {
      const PointCloud cloud = parsePointCloud(bytes);
      EXPECT_EQ(cloud.points, points) << file.name;
      EXPECT_EQ(cloud.not_finite, 0U) << file.name;
      EXPECT_FALSE(cloud.viewpoint) << file.name;
    }
  }
}

TEST(PointCloud, MayBeEmpty) {
  for (const auto& file : cloudFiles({}))
    EXPECT_TRUE(parsePointCloud(file.bytes).points.empty()) << file.name;
}

TEST(PointCloud, CountsPointsThatAreNotFinite) {
  Points points = somePoints(10);
  const float nan = std::nanf(""), infinity = std::numeric_limits<float>::infinity();
  points.insert(points.begin() + 3, {nan, 1, 2});
  points.insert(points.begin() + 5, {1, infinity, 2});
  points.emplace_back(1, 2, -infinity);
  for (const auto& file : cloudFiles(points)) {
    const PointCloud cloud = parsePointCloud(file.bytes);
    EXPECT_EQ(cloud.points, somePoints(10)) << file.name;
    EXPECT_EQ(cloud.not_finite, 3U) << file.name;
  }
}

TEST(PointCloud, HasTheViewpointOfAPcd) {
  const auto viewpointOf = [](const std::string& text) {
    return parsePointCloud(pcdFile(somePoints(2), "binary", text)).viewpoint;
  };
  EXPECT_EQ(viewpointOf("1 -2 0.5 1 0 0 0"), octomap::point3d(1, -2, 0.5F));
  EXPECT_EQ(viewpointOf("0 0 0 0 0 0 1"), octomap::point3d(0, 0, 0));
  EXPECT_FALSE(viewpointOf("0 0 0 1 0 0 0")) << "PCL writes this if it knows nothing";
  EXPECT_NE(reasonOf(pcdFile({}, "ascii", "1 2 3")), "");
  EXPECT_NE(reasonOf(pcdFile({}, "ascii", "nan 0 0 1 0 0 0")), "");
}

TEST(PointCloud, OfTextMayHaveAnyBlanks) {
  const std::string text =
      "\n VERSION .7\r\nFIELDS x y z\r\nSIZE 4 4 4\r\nTYPE F F F\r\nCOUNT 1 1 1\r\nWIDTH 2\r\n"
      "HEIGHT 1\r\n# a comment\r\nPOINTS 2\r\nDATA ascii\r\n1 2\t3\r\n  +4 -5e-1 6\r\n\r\n";
  EXPECT_TRUE(isPointCloudFile(text));
  EXPECT_EQ(parsePointCloud(text).points, (Points{{1, 2, 3}, {4, -0.5F, 6}}));
}

TEST(PointCloud, HasCoordinatesOfAnyType) {
  const std::string header =
      "VERSION 0.7\nFIELDS x y z\nSIZE 1 2 8\nTYPE I U I\nWIDTH 1\nHEIGHT 1\nDATA binary\n";
  const auto cloud =
      parsePointCloud(header + map_tests::bytesOf<int8_t>(-3) +
                      map_tests::bytesOf<uint16_t>(60000) + map_tests::bytesOf<int64_t>(-70000));
  EXPECT_EQ(cloud.points, (Points{{-3, 60000, -70000}}));
}

TEST(PointCloud, KeepsCoordinatesThatHaveNoFloat) {
  const auto cloud = parsePointCloud(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\n"
      "property double z\nend_header\n1e300 -1e300 0\n");
  ASSERT_EQ(cloud.points.size(), 1U);
  EXPECT_GT(cloud.points[0].x(), 1e20F);
  EXPECT_LT(cloud.points[0].y(), -1e20F);
}

TEST(PointCloud, OfAMeshHasItsVertices) {
  EXPECT_TRUE(parsePointCloud(plyFile(somePoints(3), "ascii")).has_faces);
  EXPECT_FALSE(parsePointCloud(pcdFile(somePoints(3), "ascii")).has_faces);
}

TEST(DamagedPointCloud, GivesAReasonAtEachCut) {
  for (const auto& file : cloudFiles(somePoints(3))) {
    // Bytes that may be missing: the face behind the vertices, and digits of the last word.
    const size_t tail = file.name == "ascii.pcd"                      ? 4
                        : file.name == "ascii.ply"                    ? 25
                        : file.name.find(".ply") != std::string::npos ? 13
                                                                      : 0;
    for (size_t size = 0; size + tail < file.bytes.size(); size++) {
      const std::string reason = reasonOf(file.bytes.substr(0, size));
      ASSERT_NE(reason, "") << file.name << " of " << size << " bytes";
      ASSERT_EQ(reason.find('\n'), std::string::npos) << reason;
    }
    EXPECT_EQ(reasonOf(file.bytes), "") << file.name;
  }
}

TEST(DamagedPointCloud, WithManyAnnouncedPointsTakesNoMemory) {
  const std::string many = "1000000000000", words = " 1 2 3 4 5 6\n";
  const auto withCount = [&](std::string bytes) {
    for (const std::string key : {"WIDTH 0", "POINTS 0", "vertex 0", "camera 1"}) {
      const size_t at = bytes.find(key);
      if (at != std::string::npos)
        bytes.replace(at + key.size() - 1, 1, key[0] == 'W' ? "2000000000" : many);
    }
    const size_t points = bytes.find(many);
    if (bytes.find("WIDTH") != std::string::npos) bytes.replace(points, many.size(), "2000000000");
    return bytes;
  };
  const map_tests::MemoryLimit limit(256);
  for (const auto& file : cloudFiles({})) {
    const std::string reason = reasonOf(withCount(file.bytes + words));
    EXPECT_NE(reason, "") << file.name;
    EXPECT_NE(reason, "std::bad_alloc") << file.name;
  }
  // Rows without properties take no bytes.
  EXPECT_NE(reasonOf("ply\nformat ascii 1.0\nelement a 1000000000000\nelement vertex 1\n"
                     "property float x\nend_header\n1\n"),
            "");
}

TEST(DamagedPointCloud, OfPackedDataIsNamed) {
  std::string bytes = pcdFile(somePoints(100), "binary_compressed");
  const size_t data = bytes.find("DATA binary_compressed\n") + 23;
  std::string wrong = bytes;
  wrong[data + 4] ^= 1;  // the size
  EXPECT_NE(reasonOf(wrong).find("size of the packed data"), std::string::npos) << reasonOf(wrong);
  std::mt19937 rng(1);
  for (int i = 0; i < 300; i++) {  // never a crash
    wrong = bytes;
    for (int k = 0; k < 3; k++) wrong[data + 8 + rng() % (bytes.size() - data - 8)] = char(rng());
    reasonOf(wrong);
  }
}

TEST(DamagedPointCloud, GivesTheReason) {
  const auto expectReason = [](const std::string& bytes, const std::string& part) {
    EXPECT_NE(reasonOf(bytes).find(part), std::string::npos) << bytes << "\n" << reasonOf(bytes);
  };
  const std::string good = pcdFile(somePoints(2), "ascii");
  const auto with = [&](const std::string& old_text, const std::string& text) {
    std::string bytes = good;
    bytes.replace(bytes.find(old_text), old_text.size(), text);
    return bytes;
  };
  expectReason(with("FIELDS x ", "FIELDS a "), "no coordinates");
  expectReason(with("SIZE 4 2", "SIZE 3 2"), "do not fit");
  expectReason(with("SIZE 4 2", "SIZE 2"), "values");
  expectReason(with("TYPE F U", "TYPE F Q"), "TYPE");
  expectReason(with("COUNT 1 1 1 1", "COUNT 2 1 1 1"), "no coordinates");
  expectReason(with("COUNT 1 1", "COUNT 1 -1"), "whole number");
  expectReason(with("HEIGHT 1", "HEIGHT 3"), "WIDTH times HEIGHT");
  expectReason(with("DATA ascii", "DATA text"), "DATA is not");
  expectReason(with("DATA ascii\n", "DATA ascii\nx"), "is not a number");
  expectReason(good + "1 2 3 4 5 6\n", "more data");
  expectReason("ply\nformat ascii 1.0\nend_header\n", "no element 'vertex'");
  expectReason("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
               "no coordinates");
  expectReason("ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n1\n",
               "unknown type");
  expectReason("ply\nformat utf8 1.0\nend_header\n", "format is not");
  expectReason("ply\nhello\nend_header\n", "no part of the format");
  expectReason("an apple", "not a point cloud");
  EXPECT_FALSE(isPointCloudFile("plywood"));
  EXPECT_FALSE(isPointCloudFile("version 1.0"));
  EXPECT_FALSE(isPointCloudFile(""));
}

}  // namespace
}  // namespace mrpt::fusion
