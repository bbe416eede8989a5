// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "support/run_program.h"

/** \file
 * Runs map-fusion in tests. */

/** A test that runs map-fusion in a new folder. */
class AppTest : public ProgramTest {
 protected:
  Result mapFusion(const std::string& arguments) const {
    return run(std::string(MAP_FUSION) + " " + arguments);
  }

  static std::string pair(const std::string& file) { return std::string(PAIR_DIR) + "/" + file; }
  static std::string both() { return pair("map_a.ot") + " " + pair("map_b.ot"); }

  /** Returns what --json wrote to report.json. */
  nlohmann::json report() const { return nlohmann::json::parse(readFile(dir_ / "report.json")); }

  /** Writes a guess file: the true pose of B in A, rotated by \a yaw_deg and moved by \a dx, m. */
  std::string guess(double dx, double yaw_deg) const {
    Eigen::Isometry3d T = readMatrix(pair("T_a_b.txt"));
    T.linear() = Eigen::AngleAxisd(yaw_deg * M_PI / 180, Eigen::Vector3d::UnitZ()) * T.linear();
    T.translation().x() += dx;
    std::ostringstream text;
    text.precision(12);
    text << T.matrix();
    writeFile(dir_ / "guess.txt", text.str());
    return "guess.txt";
  }
};
