// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/fusion/voxels.h>
#include <mrpt/maps/CProbOctoMap.h>

#include <algorithm>
#include <cstdio>

#include "mrpt_programs.h"

namespace {

class Example : public MrptPrograms {};

TEST_F(Example, BuildsWithTheInstalledTreeAsAnotherProjectAndFusesTwoMaps) {
  const auto r = run(std::string(CTEST) + " --build-and-test " + SOURCE_DIR +
                     "/doc/examples examples --build-generator '" + CMAKE_GENERATOR +
                     "' --build-options -DCMAKE_PREFIX_PATH=" + INSTALLED_PREFIX +
                     " '-DCMAKE_CXX_FLAGS=-Wall -Wextra -Werror' --test-command fuse_two_maps " +
                     pair("robot_a.rawlog") + " " + pair("robot_b.rawlog") + " fused.ot");
  ASSERT_EQ(r.code, 0) << r.out << r.err;

  const Eigen::Isometry3d truth = readMatrix(pair("T_a_b.txt"));
  double x = 0, y = 0;
  const size_t printed = r.out.find("pitch,roll)=(");
  ASSERT_NE(printed, std::string::npos) << r.out;
  ASSERT_EQ(std::sscanf(r.out.c_str() + printed, "pitch,roll)=(%lf,%lf", &x, &y), 2);
  EXPECT_NEAR(x, truth.translation().x(), 0.1);
  EXPECT_NEAR(y, truth.translation().y(), 0.1);

  const auto voxelsOf = [](const fs::path& file) {
    mrpt::maps::CProbOctoMap map;
    map.loadFromOcTreeFile(file.string());
    return mrpt::fusion::statisticsOf(map.octree()).occupied;
  };
  const size_t a = voxelsOf(pair("map_a.ot")), b = voxelsOf(pair("map_b.ot"));
  const size_t fused = voxelsOf(dir_ / "examples" / "fused.ot");
  EXPECT_GT(fused, std::max(a, b));
  EXPECT_LT(fused, a + b);
}

TEST_F(Example, IsWhatTheReadmeShows) {
  const std::string source = readFile(std::string(SOURCE_DIR) + "/doc/examples/fuse_two_maps.cpp");
  const std::string mark = "  // [README]\n";
  const size_t begin = source.find(mark) + mark.size(), end = source.rfind(mark);
  ASSERT_LT(begin, end);
  std::string excerpt;
  std::istringstream lines(source.substr(begin, end - begin));
  for (std::string line; std::getline(lines, line);)
    excerpt += line.substr(std::min<size_t>(2, line.size())) + "\n";
  EXPECT_NE(readFile(std::string(SOURCE_DIR) + "/README.md").find(excerpt), std::string::npos)
      << excerpt;
}

}  // namespace
