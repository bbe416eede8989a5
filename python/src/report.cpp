// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reports and pages of results: those of map-fusion. */

#include <mrpt/fusion/merging.h>

#include <string>

#include "bindings.h"
#include "fusion_base/files.h"
#include "fusion_report/json.h"
#include "fusion_report/page/page.h"
#include "poses.h"
#include "results.h"

using mrpt::fusion::PageMap;
using mrpt::fusion::PageScene;
using mrpt::fusion::Report;
using mrpt::fusion::toEigen;

namespace mrpt_fusion_python {
namespace {

void addMap(Report& report, const std::string& role, const Map& map) {
  report.maps.push_back(mrpt::fusion::reportOn(role, map.origin().path, *map.octree()));
  if (!map.isEdgesAlone()) report.maps.back().sources = map.whole().sources();
}

Report reportOf(const Map& map) {
  Report report;
  report.command = "view";
  addMap(report, "map", map);
  return report;
}

Report reportOf(const Match& match) {
  Report report;
  report.command = match.command;
  addMap(report, "a", *match.a);
  addMap(report, "b", *match.b);
  report.initial_pose = match.guess;
  report.pose = match.alignment.pose();
  report.match = match.alignment;
  report.seconds = {{"match", match.alignment.seconds_matching},
                    {"evaluate", match.alignment.seconds_evaluation}};
  return report;
}

Report reportOf(const Fusion& fusion) {
  Report report;
  if (fusion.match) {
    report = reportOf(*fusion.match);
  } else {
    for (const Robot& robot : fusion.robots) addMap(report, robot.name, *robot.map);
    report.members = fusion.members;
    report.pairs = fusion.pairs;
  }
  report.command = "fuse";
  if (!fusion.map) return report;
  if (fusion.merged) report.counting = fusion.merged->counting;
  for (const auto& [policy, name] : mrpt::fusion::mergePolicyNames())
    if (policy == fusion.settings.options.merge.policy) report.policy = name;
  addMap(report, "fused", *fusion.map);
  return report;
}

void addMap(PageScene& scene, const std::string& name, const Map& map, const Settings& settings,
            const Eigen::Isometry3d& pose = Eigen::Isometry3d::Identity(), bool is_shown = true) {
  auto edges = std::make_shared<const mrpt::fusion::EdgeVoxels>(map.prepared(settings).edges());
  scene.maps.push_back({name, map.octree(), pose, is_shown, std::move(edges)});
}

PageScene sceneOf(const Map& map) {
  PageScene scene;
  scene.maps.push_back(
      {map.origin().name, map.octree(), Eigen::Isometry3d::Identity(), true, nullptr});
  return scene;
}

PageScene sceneOf(const Match& match) {
  PageScene scene;
  scene.kind = PageScene::Kind::Pair;
  scene.limits = match.settings.options.evaluation;
  addMap(scene, "A", *match.a, match.settings);
  addMap(scene, "B", *match.b, match.settings, match.alignment.match.T_a_b);
  return scene;
}

PageScene sceneOf(const Fusion& fusion) {
  PageScene scene;
  if (fusion.match) {
    scene = sceneOf(*fusion.match);
  } else {
    scene.kind = PageScene::Kind::Team;
    scene.limits = fusion.settings.options.evaluation;
    for (size_t i = 0; i < fusion.robots.size(); i++) {
      const auto& member = fusion.members[i];
      const auto& map = *fusion.robots[i].map;
      scene.maps.push_back({member.robot, map.octree(), toEigen(member.pose.mean),
                            member.joined || member.alignment.by_edges, nullptr});
    }
  }
  if (fusion.map) scene.fused = fusion.map->octree();
  return scene;
}

template <class Result>
std::string pageOf(const Result& result) {
  const py::gil_scoped_release release;
  const Report report = reportOf(result);
  return mrpt::fusion::toPage(report, mrpt::fusion::toSceneJson(report, sceneOf(result)));
}

/** Returns a page as a frame in the page of a notebook. */
std::string frameOf(const std::string& page) {
  std::string frame =
      "<iframe sandbox=\"allow-scripts\" style=\"width:100%;height:640px;border:0\" "
      "srcdoc=\"";
  frame.reserve(frame.size() + page.size() + page.size() / 8);
  for (const char c : page) {
    if (c == '&')
      frame += "&amp;";
    else if (c == '"')
      frame += "&quot;";
    else
      frame += c;
  }
  return frame + "\"></iframe>";
}

template <class Result>
py::object figuresOf(const Result& result) {
  std::string json;
  {
    const py::gil_scoped_release release;
    json = mrpt::fusion::toJson(reportOf(result));
  }
  return py::module_::import("json").attr("loads")(json);
}

template <class Result>
void savePage(const Result& result, const py::object& path) {
  const std::string file = pathOf(path), page = pageOf(result);
  const py::gil_scoped_release release;
  mrpt::fusion::writeFileAtomically(file, page);
}

template <class Result, class... Holder>
void addReports(py::module_& m, const char* name) {
  py::class_<Result, Holder...> type{py::object(m.attr(name))};
  type.def("figures", &figuresOf<Result>, R"(figures() -> dict

Return all figures, as map-fusion --json writes them: see doc/report.schema.json.
)");
  type.def("save_page", &savePage<Result>, py::arg("path"), R"(save_page(path) -> None

Write a page: one HTML file with the maps in 3-D and all figures, for any browser, without network.
)");
  type.def(
      "_repr_html_", [](const Result& self) { return frameOf(pageOf(self)); },
      "Return the page for a notebook.");
}

}  // namespace

void bindReport(py::module_& m) {
  addReports<Map, std::shared_ptr<Map>>(m, "Map");
  addReports<Match>(m, "Match");
  addReports<Fusion, std::shared_ptr<Fusion>>(m, "Fusion");
}

}  // namespace mrpt_fusion_python
