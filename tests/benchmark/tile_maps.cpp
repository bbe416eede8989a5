// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Makes a large pair of maps from a small one, to measure how times grow with the maps.
 */
#include <CLI/CLI.hpp>
#include <iostream>
#include <sstream>
#include <stdexcept>

#include "tiling.h"

namespace {

int run(int argc, char** argv) {
  CLI::App app{"A pair of maps that are copies, side by side, of a pair's."};
  std::string folder, copies, out;
  app.add_option("PAIR", folder, "Folder with map_a.ot, map_b.ot, T_a_b.txt")->required();
  app.add_option("--copies", copies, "NXxNY: how many along A's x and y")->required();
  app.add_option("--out", out, "Folder to write such a pair into")->required();
  uint32_t nx = 0, ny = 0;
  try {
    app.parse(argc, argv);
    char by = 0;
    std::istringstream text(copies);
    if (!(text >> nx >> by >> ny) || by != 'x' || !(text >> std::ws).eof() || nx == 0 || ny == 0)
      throw CLI::ValidationError("--copies", "is not of the form 2x5");
  } catch (const CLI::Error& e) {
    return app.exit(e) ? 2 : 0;
  }
  using namespace mrpt::fusion::benchmark;
  writeTiledPair(loadMapPair(folder), nx, ny, out);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    std::cerr << "tile-maps: " << e.what() << "\n";
    return 1;
  }
}
