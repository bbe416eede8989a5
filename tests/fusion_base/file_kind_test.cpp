// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the recognition of files that are no maps. */
#include "fusion_base/file_kind.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

using mrpt::fusion::beginsWithObject;
using mrpt::fusion::foreignKindOf;

TEST(FileKind, SaysWhatAFileSeemsToBe) {
  using namespace std::string_view_literals;
  const std::vector<std::pair<std::string_view, const char*>> files = {
      {"LASF\1\2"sv, "point cloud"},
      {"ASTM-E57\1\0"sv, "point cloud"},
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

TEST(FileKind, ObjectsOfMrptBeginWithTheNameOfTheirClass) {
  using namespace std::string_view_literals;
  for (const auto bytes : {"\x98mrpt::maps::CProbOctoMap\0"sv,
                           "\x8d"
                           "CSensoryFrame\x02"sv,
                           "\x0d"
                           "CSensoryFrame\x02"sv})
    EXPECT_TRUE(beginsWithObject(bytes)) << bytes;
  EXPECT_TRUE(beginsWithObject("\x98mrpt::maps::CProbOctoMap\0"sv, "CProbOctoMap"));
  EXPECT_TRUE(
      beginsWithObject("\x8a"
                       "CSimpleMap\x01"sv,
                       "CSimpleMap"));
  // The first format of MRPT
  EXPECT_TRUE(
      beginsWithObject("\x16\0\0\0CSensFrameProbSequence\0\0\0\0H"sv, "CSensFrameProbSequence"));
  EXPECT_FALSE(beginsWithObject("\x98mrpt::maps::CProbOctoMap\0"sv, "OctoMap"));
  EXPECT_FALSE(beginsWithObject("\x98mrpt::maps::CProbOctoMap\0"sv, "CSimpleMap"));
  // Nodes of octrees: a log-odds (float) and the mask of children, or two bytes of children.
  for (const auto bytes :
       {""sv, "\0\0\0\0\xff"sv, "\x9a\x99\x19?\x01\x9a\x99\x19?"sv, "\x55\xaa\x55"sv})
    EXPECT_FALSE(beginsWithObject(bytes)) << bytes;
}
