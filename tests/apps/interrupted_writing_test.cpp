// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of runs that end while they write a file: no temporary file is left. */

#include <algorithm>
#include <csignal>
#include <string>
#include <vector>

#include "run.h"
#include "support/sanitizers.h"

namespace {

class InterruptedWriting : public AppTest {
 protected:
  void SetUp() override {
    AppTest::SetUp();
    fs::copy_file(pair("map_a.ot"), dir_ / "a.ot");
    outputs_ = dir_ / "outputs";
    fs::create_directory(outputs_);
  }

  /** Returns a command that writes a file with the program or with the module of MRPT's maps. */
  static std::string moveTo(const std::string& output) {
    return std::string(MAP_FUSION) + " transform -q a.ot --pose '[1 0 0 0 0 0]' -o outputs/" +
           output;
  }

  /** Runs a command that gets a signal while it writes a file. \return Its exit code; 128 and the
   * number of the signal if the signal ended it. */
  int runWithSignal(const std::string& command, int signal, const std::string& effect) const {
    const std::string number = std::to_string(signal);
    return run("env --" + effect + "-signal=" + number + " LD_PRELOAD=" SIGNAL_AT_FSYNC +
               " SIGNAL_AT_FSYNC=" + number + " " + command + "; code=$?; exit $code")
        .code;
  }

  std::vector<std::string> outputs() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(outputs_))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }

  fs::path outputs_;
};

/** Outputs that the program writes, and that the module of MRPT's maps writes. */
const std::vector<std::string> kWriters = {"moved.ot", "moved.gz"};

TEST_F(InterruptedWriting, ASignalLeavesTheOldFileAndNoOther) {
  if (map_tests::kHasSanitizer) GTEST_SKIP() << "sanitizers must be loaded first";
  for (const std::string& output : kWriters)
    for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
      writeFile(outputs_ / output, "the old map");
      EXPECT_EQ(runWithSignal(moveTo(output), signal, "default"), 128 + signal) << output;
      EXPECT_EQ(readFile(outputs_ / output), "the old map") << signal;
      EXPECT_EQ(outputs(), std::vector<std::string>{output}) << signal;
      fs::remove(outputs_ / output);
      EXPECT_EQ(runWithSignal(moveTo(output), signal, "default"), 128 + signal) << output;
      EXPECT_EQ(outputs(), std::vector<std::string>()) << output << " " << signal;
    }
}

TEST_F(InterruptedWriting, TheSignalOfThisTestComesWhileThereIsATemporaryFile) {
  if (map_tests::kHasSanitizer) GTEST_SKIP() << "sanitizers must be loaded first";
  for (const std::string& output : kWriters) {
    EXPECT_EQ(runWithSignal(moveTo(output), SIGKILL, "block"), 128 + SIGKILL);
    const auto left = outputs();
    ASSERT_EQ(left.size(), 1U) << output;
    EXPECT_EQ(left[0].rfind(output + ".", 0), 0U) << left[0];
    fs::remove(outputs_ / left[0]);
  }
}

TEST_F(InterruptedWriting, ASignalThatTheCallerIgnoresIsIgnored) {
  if (map_tests::kHasSanitizer) GTEST_SKIP() << "sanitizers must be loaded first";
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
    EXPECT_EQ(runWithSignal(moveTo("moved.ot"), signal, "ignore"), 0);
    EXPECT_EQ(outputs(), std::vector<std::string>{"moved.ot"});
  }
}

TEST_F(InterruptedWriting, AFileThatGrowsTooLargeIsOneLineAndLeavesTheOldFile) {
  const std::string limit = "ulimit -f 100; ";  // blocks of 512 bytes
  for (const std::string& output : {std::string("moved.ot"), std::string("moved.bt"),
                                    std::string("moved.gz"), std::string("moved.map")}) {
    for (const bool is_new : {false, true}) {
      if (!is_new) writeFile(outputs_ / output, "the old map");
      const auto r = run(limit + moveTo(output));
      EXPECT_EQ(r.code, 1) << output;
      EXPECT_NE(r.err.find(output + ": cannot be written: File too large"), std::string::npos)
          << r.err;
      EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
      if (is_new) {
        EXPECT_EQ(outputs(), std::vector<std::string>());
      } else {
        EXPECT_EQ(outputs(), std::vector<std::string>{output});
        EXPECT_EQ(readFile(outputs_ / output), "the old map");
        fs::remove(outputs_ / output);
      }
    }
  }
}

}  // namespace
