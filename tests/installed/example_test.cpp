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
  const auto expectFused = [&](const fs::path& file) {
    const size_t fused = voxelsOf(file);
    EXPECT_GT(fused, std::max(a, b)) << file;
    EXPECT_LT(fused, a + b) << file;
  };
  expectFused(dir_ / "examples" / "fused.ot");

  const std::string octrees = "examples/fuse_two_octrees " + pair("map_a.ot") + " ";
  const auto fused = run(octrees + pair("map_b.ot") + " octrees.ot");
  ASSERT_EQ(fused.code, 0) << fused.out << fused.err;
  EXPECT_NE(fused.out, "");
  expectFused(dir_ / "octrees.ot");
  EXPECT_EQ(run(octrees + pair("T_a_b.txt") + " none.ot").code, 1);
  EXPECT_FALSE(fs::exists(dir_ / "none.ot"));
}

TEST_F(Example, IsWhatTheReadmeShows) {
  for (const std::string name : {"fuse_two_maps", "fuse_two_octrees"}) {
    const std::string source = readFile(std::string(SOURCE_DIR) + "/doc/examples/" + name + ".cpp");
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
}

TEST_F(Example, IsInstalledWithReadmeAndLicence) {
  const fs::path doc = fs::path(INSTALLED_PREFIX) / "share/doc/mrpt-fusion";
  for (const char* file : {"README.md", "LICENSE", "CHANGELOG.md", "examples/CMakeLists.txt",
                           "examples/fuse_two_maps.cpp", "examples/fuse_two_octrees.cpp"})
    EXPECT_TRUE(fs::is_regular_file(doc / file)) << file;
}

}  // namespace
