// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_base/file_names.h"

#include <gtest/gtest.h>

namespace mrpt::fusion::test::file_names_test {
namespace {

using Names = std::vector<std::string>;

TEST(FileNames, AreThoseOfTheFilesWithoutExtension) {
  EXPECT_EQ(namesOf({"/maps/r1.ot", "r2.rawlog"}), (Names{"r1", "r2"}));
}

TEST(FileNames, HaveTheFoldersOfAllIfFilesHaveTheSameName) {
  EXPECT_EQ(namesOf({"/x/one/maps/map.ot", "/x/two/maps/map.ot", "/y/three/other.ot"}),
            (Names{"one_maps_map", "two_maps_map", "y_three_other"}));
}

TEST(FileNames, AreTheSameForTheSameFile) {
  EXPECT_EQ(namesOf({"/x/map.ot", "/x/y/../map.ot"}), (Names{"map", "map"}));
}

TEST(FileNames, EndAtTheTopFolder) {
  EXPECT_EQ(namesOf({"/map.ot", "/map.bt"}), (Names{"map", "map"}));
}

TEST(FileNames, OfOneFileMayDiffer) {
  EXPECT_TRUE(isSameFile("/", "/."));
  EXPECT_TRUE(isSameFile("/not there", "/not there"));
  EXPECT_FALSE(isSameFile("/not there", "/nor there"));
  EXPECT_FALSE(isSameFile("/", "/not there"));
}

}  // namespace
}  // namespace mrpt::fusion::test::file_names_test
