// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "support/run_program.h"

/** MRPT's own programs, with the library as it is installed in them. */
class MrptPrograms : public ProgramTest {
 protected:
  static std::string plugin() { return INSTALLED_PLUGIN; }
  static std::string mapFusion() { return INSTALLED_PREFIX "/bin/map-fusion"; }

  /** A program that has no flag for plugins, with ours in it. */
  Result runWithPlugin(const std::string& command) const {
    return run("LD_PRELOAD=" + plugin() + " " + command);
  }

  /** Starts a program without and with arguments, each on a screen of its own, and expects that
   * the second shows at least so many pixels that the first does not. */
  void expectShows(const std::string& program, const std::string& arguments, int pixels) const {
    const std::string picture_of = PICTURE_OF;
    const auto empty = run(picture_of + " empty.png '' 0 " + program);
    ASSERT_EQ(empty.code, 0) << empty.err;
    const auto filled = run(picture_of + " filled.png empty.png " + std::to_string(pixels) + " " +
                            program + " " + arguments);
    EXPECT_EQ(filled.code, 0) << filled.err;
  }

  /** Files of the two robots that the tests share. */
  static std::string pair(const std::string& file) { return std::string(PAIR_DIR) + "/" + file; }
};
