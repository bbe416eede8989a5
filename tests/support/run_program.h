// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <Eigen/Geometry>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

/** \file
 * A test fixture that runs programs. */

namespace fs = std::filesystem;

inline std::string readFile(const fs::path& path) {
  std::ifstream f(path, std::ios::binary);
  std::ostringstream text;
  text << f.rdbuf();
  return text.str();
}

inline void writeFile(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

inline Eigen::Isometry3d readMatrix(const fs::path& path) {
  std::ifstream f(path);
  Eigen::Isometry3d T;
  for (int row = 0; row < 4; row++)
    for (int col = 0; col < 4; col++) f >> T.matrix()(row, col);
  EXPECT_TRUE(f.good()) << path << " does not hold a 4x4 matrix";
  return T;
}

/** Fixture with a new folder for each test. Programs run in this folder. */
class ProgramTest : public ::testing::Test {
 protected:
  struct Result {
    int code;
    std::string out, err;
  };

  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "mrpt-fusion-test.XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    dir_ = name;
  }
  void TearDown() override { fs::remove_all(dir_); }

  /** Runs a shell command in the test's folder. */
  Result run(const std::string& command) const {
    const std::string line =
        "cd '" + dir_.string() + "' && ( " + command + " ) >.stdout 2>.stderr </dev/null";
    const int status = std::system(line.c_str());  // NOLINT(cert-env33-c): tests run programs
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, readFile(dir_ / ".stdout"),
            readFile(dir_ / ".stderr")};
  }

  fs::path dir_;
};
