// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * team_member ROBOT DOMAIN MAP.ot FUSED.ot: a program that joins robots through
 * mrpt::slam::CMapTeam, until it is killed. */
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/slam/CMapTeam.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <iostream>
#include <memory>
#include <string>
#include <thread>

int main(int argc, char** argv) try {
  if (argc != 5) return 2;
  mrpt::maps::CProbOctoMap map;
  map.loadFromOcTreeFile(argv[3]);
  mrpt::slam::CMapTeam team({}, {argv[1], static_cast<uint32_t>(std::stoul(argv[2])), {}, {}});
  team.setMap(argv[1], map);
  const std::string fused_path = argv[4], part_path = fused_path + ".part";
  std::shared_ptr<const mrpt::maps::CProbOctoMap> saved;
  while (true) {
    if (const auto fused = team.fusedMap(); fused && fused != saved) {
      fused->saveToOcTreeFile(part_path);
      std::rename(part_path.c_str(), fused_path.c_str());
      saved = fused;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
