// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Collects what a page shows, and opens pages. */

#include "pages.h"

#include <fcntl.h>
#include <mrpt/fusion/poses.h>
#include <spawn.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <utility>

#include "fusion_report/page/page.h"

namespace map_fusion {
namespace {

using mrpt::fusion::PageMap;
using mrpt::fusion::PageScene;
using mrpt::fusion::toEigen;

void draw(RunContext& run, PageScene& scene) {
  run.progress.show("drawing");
  scene.limits = run.options.evaluation;
  run.page_scene = mrpt::fusion::toSceneJson(run.report, scene);
  run.progress.clear();
  run.endStep("report");
}

PageMap pageMapOf(const Robot& robot) {
  PageMap map;
  map.name = robot.name;
  map.octree = robot.map.octree;
  map.edges = robot.map.edges;
  return map;
}

bool hasDisplay() {
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY"})
    if (const char* value = std::getenv(name); value && *value) return true;
  return false;
}

}  // namespace

void drawPage(RunContext& run, const MapPair& pair) {
  if (run.args.page.empty()) return;
  PageScene scene;
  scene.kind = PageScene::Kind::Pair;
  const auto add = [&](const char* name, const LoadedMap& loaded, const auto* prepared) {
    PageMap& map = scene.maps.emplace_back();
    map.name = name;
    map.octree = loaded.octree;
    if (prepared) map.edges = std::make_shared<const mrpt::fusion::EdgeVoxels>(prepared->edges());
  };
  add("A", pair.a, pair.prepared ? &pair.prepared->first : nullptr);
  add("B", pair.b, pair.prepared ? &pair.prepared->second : nullptr);
  scene.maps[1].pose = toEigen(run.report.pose->mean);
  scene.fused = pair.fused;
  draw(run, scene);
}

void drawTeamPage(RunContext& run, const std::vector<Robot>& robots,
                  const std::shared_ptr<const octomap::OcTree>& fused) {
  if (run.args.page.empty()) return;
  PageScene scene;
  scene.kind = PageScene::Kind::Team;
  for (size_t i = 0; i < robots.size(); i++) {
    const auto& member = run.report.members[i];
    PageMap& map = scene.maps.emplace_back(pageMapOf(robots[i]));
    map.pose = toEigen(member.pose.mean);
    map.is_shown = member.joined || member.alignment.by_edges;
  }
  scene.fused = fused;
  draw(run, scene);
}

void drawMapsPage(RunContext& run, const std::vector<Robot>& robots) {
  PageScene scene;
  for (const Robot& robot : robots) {
    scene.maps.push_back(pageMapOf(robot));
    scene.maps.back().is_shown = scene.maps.size() == 1;
  }
  draw(run, scene);
}

bool openPage(const std::string& path) {
  if (!hasDisplay()) return false;
  std::string opener = "xdg-open", page = std::filesystem::absolute(path).string();
  char* const arguments[] = {opener.data(), page.data(), nullptr};
  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  for (const int output : {STDOUT_FILENO, STDERR_FILENO})
    ::posix_spawn_file_actions_addopen(&files, output, "/dev/null", O_WRONLY, 0);
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);  // it outlives this program
  pid_t child = 0;
  const int failed =
      ::posix_spawnp(&child, opener.c_str(), &files, &attributes, arguments, environ);
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&files);
  return failed == 0;
}

}  // namespace map_fusion
