// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of runs whose memory is limited. */

#include <octomap/octomap.h>

#include <algorithm>
#include <string>
#include <vector>

#include "run.h"
#include "support/sanitizers.h"

namespace {

class LittleMemory : public AppTest {
 protected:
  void SetUp() override {
    AppTest::SetUp();
    if (map_tests::kHasSanitizer) GTEST_SKIP() << "sanitizers reserve terabytes of addresses";
  }

  Result runWithin(size_t megabytes, const std::string& arguments) const {
    return run("ulimit -c 0; ulimit -v " + std::to_string(megabytes << 10U) + "; " MAP_FUSION " " +
               arguments + "; code=$?; exit $code");
  }

  /** Returns the smallest limit in megabytes at which the system can load the program. */
  size_t sizeOfTheProgram() const {
    constexpr int kNotLoaded = 127;
    size_t too_little = 0;
    size_t enough = 4096;
    while (enough - too_little > 1) {
      const size_t middle = (enough + too_little) / 2;
      (runWithin(middle, "--version").code == kNotLoaded ? too_little : enough) = middle;
    }
    return enough;
  }

  /** Runs with more and more memory. Each run that does not succeed says that the memory was not
   * enough, on one line. */
  void expectOneLineWithin(const std::vector<size_t>& limits, const std::string& arguments) const {
    size_t failures = 0;
    for (const size_t limit : limits) {
      const auto r = runWithin(limit, arguments);
      if (r.code == 0) {
        for (const auto& entry : fs::directory_iterator(dir_))
          if (isOutput(entry)) fs::remove(entry);
        continue;
      }
      failures++;
      EXPECT_EQ(r.code, 1) << limit << " MB: " << arguments << "\n" << r.err;
      EXPECT_NE(r.err.find("out of memory"), std::string::npos) << limit << " MB: " << r.err;
      EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << limit << " MB: " << r.err;
      EXPECT_EQ(r.out, "") << limit << " MB";
      for (const auto& entry : fs::directory_iterator(dir_))
        EXPECT_FALSE(isOutput(entry)) << limit << " MB left " << entry.path();
    }
    EXPECT_GT(failures, 0U) << "no limit was too small: " << arguments;
  }

  static bool isOutput(const fs::directory_entry& entry) {
    return entry.path().filename().string().rfind("out", 0) == 0;
  }

  static std::vector<size_t> sizes(size_t first, size_t last, size_t step) {
    std::vector<size_t> all;
    for (size_t size = first; size <= last; size += step) all.push_back(size);
    return all;
  }
};

TEST_F(LittleMemory, IsOneLineAtTheStart) {
  const size_t base = sizeOfTheProgram();
  expectOneLineWithin(sizes(base, base + 12, 1), "info -q " + pair("map_a.ot"));
}

TEST_F(LittleMemory, IsOneLineOfCommandsOnTwoMaps) {
  const size_t base = sizeOfTheProgram();
  expectOneLineWithin(sizes(base + 1, base + 58, 3), "match -q " + both());
  expectOneLineWithin(sizes(base + 1, base + 58, 3),
                      "merge -q " + both() + " --pose " + pair("T_a_b.txt") + " -o out.ot");
}

TEST_F(LittleMemory, IsOneLineOfALargeMap) {
  octomap::OcTree tree(0.1);
  for (int x = 0; x < 250; x++)
    for (int y = 0; y < 250; y++)
      for (int z = 0; z < 12; z++)  // no siblings are equal
        tree.setNodeValue(octomap::OcTreeKey(static_cast<octomap::key_type>(32768 + x),
                                             static_cast<octomap::key_type>(32768 + y),
                                             static_cast<octomap::key_type>(32768 + z)),
                          0.01F * static_cast<float>((x + 2 * y + 4 * z) % 8 + 1), true);
  tree.updateInnerOccupancy();
  ASSERT_TRUE(tree.write((dir_ / "large.ot").string()));
  const size_t base = sizeOfTheProgram();
  for (const std::string arguments : {"info -q large.ot", "edges -q large.ot -o out.ply"}) {
    const auto r = runWithin(base + 16, arguments);
    EXPECT_EQ(r.code, 1) << arguments;
    EXPECT_EQ(r.err, "map-fusion: large.ot: out of memory\n");
  }
}

TEST_F(LittleMemory, IsOneLineOfMrptsMaps) {
  const size_t base = sizeOfTheProgram();
  expectOneLineWithin(sizes(base + 10, base + 260, 10),
                      "build -q " + pair("robot_a.rawlog") + " -o out.ot");
}

}  // namespace
