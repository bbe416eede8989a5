// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the recognition of files that are no maps. */
#include "fusion_base/file_kind.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

using mrpt::fusion::foreignKindOf;

TEST(FileKind, SaysWhatAFileSeemsToBe) {
  using namespace std::string_view_literals;
  const std::vector<std::pair<std::string_view, const char*>> files = {
      {"# .PCD v0.7 - Point Cloud Data\n"sv, "point cloud"},
      {"ply\nformat ascii 1.0\n"sv, "point cloud"},
      {"#ROSBAG V2.0\n"sv, "ROS recording"},
      {"SQLite format 3\0"sv, "ROS recording"},
      {"\x89MCAP0\r\n"sv, "ROS recording"},
      {"version https://git-lfs.github.com/spec/v1\n"sv, "git lfs pull"},
      {"\n <!DOCTYPE html>\n<html>"sv, "web page"},
      {"\xef\xbb\xbf<HTML>"sv, "web page"},
      {"\x89PNG\r\n\x1a\n\0\0\0"sv, "picture"},
      {"\xff\xd8\xff\xe0"sv, "picture"},
      {"P5\n100 100\n255\n"sv, "2-D grid map"},
      {"image: map.pgm\nresolution: 0.05\n"sv, "2-D grid map"},
      {"PK\x03\x04zip"sv, "unpack"},
      {"BZh91AY"sv, "bunzip2"},
      {"some notes about a map\n"sv, "text file"},
  };
  for (const auto& [bytes, part] : files) {
    const std::string kind = foreignKindOf(bytes);
    EXPECT_NE(std::string::npos, kind.find(part)) << bytes << ": " << kind;
    for (const char c : kind) EXPECT_GE(c, ' ') << kind;
  }
}

TEST(FileKind, IsUnknownForBytesThatMayBeAMap) {
  using namespace std::string_view_literals;
  for (const auto bytes : {"\x96mrpt::maps::CProbOctoMap"sv, "\0\0\0\0\0"sv, ""sv, "abc"sv})
    EXPECT_EQ("", foreignKindOf(bytes));
}
