// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Command line: robots drive through a building, and out come their rawlogs, the one that a robot
 * without pose errors would have recorded on all their drives, and the true T_a_b. For more than
 * two robots, also the true pose of the world in the frame of each robot.
 */
#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>

#include "buildings.h"
#include "mission.h"

namespace {

namespace fs = std::filesystem;
using namespace mrpt::fusion::sim;

/** What `task` returns. OctoMap chats on std::cerr meanwhile; to tell of a failure is for main().
 */
template <typename Task>
bool withoutChat(Task task) {
  struct Silence {
    Silence() { std::cerr.setstate(std::ios::failbit); }
    ~Silence() { std::cerr.clear(); }
  } silence;
  return task();
}

World loadBuilding(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + ": cannot be opened");
  octomap::OcTree tree(1.0);  // the file brings its own voxel size
  const bool complete = withoutChat([&] { return tree.readBinary(file); });
  if (!complete || tree.size() == 0) throw std::runtime_error(path + ": is not a complete .bt map");
  return VoxelGrid(tree);
}

/** A generated building by its name, else one from a file. */
World makeWorld(const std::string& nameOrPath) {
  if (nameOrPath == "lobby") return lobby();
  if (nameOrPath == "office") return office();
  if (nameOrPath == "storey") return storey();
  return loadBuilding(nameOrPath);
}

void writeWorld(const World& world, const std::string& path) {
  octomap::OcTree tree = world.solid.toOcTree();
  std::ofstream file(path, std::ios::binary);
  const bool written = withoutChat([&] { return tree.writeBinary(file); });
  if (!written || !file.flush()) throw std::runtime_error(path + ": cannot be written");
}

void writePose(const mrpt::poses::CPose3D& pose, const fs::path& path) {
  std::ofstream file(path);
  const auto matrix = pose.getHomogeneousMatrixVal<mrpt::math::CMatrixDouble44>();
  file << std::setprecision(12) << matrix.asEigen() << "\n";
  if (!file.flush()) throw std::runtime_error(path.string() + ": cannot be written");
}

void printSummary(const std::string& name, const Recording& recording) {
  size_t points = 0;
  for (const Scan& scan : recording.scans) points += scan.points.size();
  std::cout << name << ": " << recording.scans.size() << " scans, " << points << " points\n";
}

void simulate(const Mission& mission, const World& world, const fs::path& outDir) {
  auto recordings = runMission(world, mission);
  fs::create_directories(outDir);
  for (size_t i = 0; i < recordings.size(); ++i) {
    const std::string& name = mission.robots[i].name;
    writeRawlog(recordings[i], (outDir / name).string() + ".rawlog");
    printSummary(name, recordings[i]);
  }
  if (recordings.size() > 1) {
    const auto T_a_b = relativePoseTruth(recordings[0], recordings[1]);
    writePose(T_a_b, outDir / "T_a_b.txt");
    std::cout << "T_a_b: " << T_a_b << "\n";
  }
  writePose(worldPoseTruth(recordings[0]), outDir / "T_a_w.txt");
  if (recordings.size() > 2)
    for (size_t i = 0; i < recordings.size(); ++i)
      writePose(worldPoseTruth(recordings[i]), outDir / ("T_" + mission.robots[i].name + "_w.txt"));
  writeRawlog(withoutPoseErrors(std::move(recordings)), (outDir / "all.rawlog").string());
}

int run(int argc, char** argv) {
  CLI::App app{"Simulates robots that map a building, each in its own frame."};
  std::string missionPath, worldName, outDir, worldOut;
  uint32_t seed = 0;
  app.add_option("MISSION", missionPath, "Mission file (.ini)")->required();
  app.add_option("--world", worldName, "The building: a .bt file, lobby, office or storey")
      ->required();
  app.add_option("--out", outDir, "Folder for the results, made if need be")->required();
  app.add_option("--write-world", worldOut, "Save the building as an OctoMap (.bt)");
  const auto* seedOption = app.add_option("--seed", seed, "In place of the seed of the mission");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  }

  Mission mission = loadMission(missionPath);
  if (*seedOption) mission.seed = seed;
  const World world = makeWorld(worldName);
  if (!worldOut.empty()) writeWorld(world, worldOut);
  simulate(mission, world, outDir);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    std::cerr << "simulate-robots: " << e.what() << "\n";
    return 1;
  }
}
