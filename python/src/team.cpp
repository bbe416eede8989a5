// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * A team whose maps change. */

#include <pybind11/stl.h>

#include <map>
#include <mutex>
#include <stdexcept>

#include "bindings.h"
#include "fusion_base/error_text.h"
#include "poses.h"
#include "results.h"

namespace mrpt_fusion_python {
namespace {

/** mrpt::fusion::MapTeam with the maps that its results are about. */
class Team {
 public:
  explicit Team(Settings settings) : settings_(std::move(settings)), team_(settings_.options) {}

  void set(const std::string& robot, const MapPtr& map,
           const mrpt::poses::CPose3DPDFGaussian& pose) {
    auto prepared = mrpt::fusion::withPath(robot, [&] { return map->prepared(settings_); });
    if (prepared.occupiedVoxels() == 0)
      throw std::runtime_error(robot + ": the map has no occupied voxel");
    const std::lock_guard<std::mutex> lock(mutex_);
    team_.set({robot, std::move(prepared), pose});
    maps_[robot] = map;
  }

  bool remove(const std::string& robot) {
    const std::lock_guard<std::mutex> lock(mutex_);
    maps_.erase(robot);
    return team_.remove(robot);
  }

  std::vector<std::string> robots() const { return team_.robots(); }

  /** Returns the state of the present maps. The same object if nothing has changed. */
  std::shared_ptr<Fusion> state() {
    const auto maps = [this] {
      const std::lock_guard<std::mutex> lock(mutex_);
      return maps_;
    }();
    const auto state = team_.state();
    const std::lock_guard<std::mutex> lock(result_mutex_);
    if (result_ && result_of_ == state) return result_;
    auto fusion = std::make_shared<Fusion>(Fusion{{}, settings_, nullptr});
    for (const auto& member : state->members) {
      const auto map = maps.find(member.robot);
      if (map != maps.end()) fusion->robots.push_back({member.robot, map->second});
    }
    fusion->members = state->members;
    fusion->pairs = state->pairs;
    if (state->map)
      fusion->map = mapOf(std::make_unique<octomap::OcTree>(*state->map), state->sources);
    result_of_ = state;
    result_ = std::move(fusion);
    return result_;
  }

 private:
  Settings settings_;
  mrpt::fusion::MapTeam team_;
  std::mutex mutex_;
  std::map<std::string, MapPtr> maps_;
  std::mutex result_mutex_;
  std::shared_ptr<const mrpt::fusion::TeamState> result_of_;
  std::shared_ptr<Fusion> result_;
};

void set(Team& team, const std::string& robot, const py::object& map, const py::object& pose) {
  const MapPtr loaded = mapOf(map);
  const auto guess =
      pose.is_none() ? loaded->origin().pose
                     : mrpt::poses::CPose3DPDFGaussian(mrpt::fusion::toPose(poseOf(pose, "pose")));
  const py::gil_scoped_release release;
  team.set(robot, loaded, guess);
}

}  // namespace

void bindTeam(py::module_& m) {
  using Released = py::call_guard<py::gil_scoped_release>;
  py::class_<Team>(m, "MapTeam", R"(MapTeam(options={})

A team whose maps change: robots come, send newer maps, and go. The state is that of fuse() with the
present maps. A change costs the matches of the changed map. Several threads may use a team, and a
change does not wait for a fusion. The robot that came first keeps its frame.

>>> team = mf.MapTeam()
>>> team.set('r1', 'a.ot')
>>> team.set('r2', 'b.ot')
>>> team.state().members[1].joined
True
>>> team.remove('r2')
True
>>> team.robots
['r1']
)")
      .def(py::init([](const py::object& options) {
             return std::make_unique<Team>(settingsOf(options));
           }),
           py::arg("options") = py::dict())
      .def("set", &set, py::arg("robot"), py::arg("map"), py::arg("pose") = py::none(),
           R"(set(robot, map, pose=None) -> None

Add the map of a robot, or replace it. pose: guess of the map's 4x4 pose in a common frame.
)")
      .def("remove", &Team::remove, py::arg("robot"), Released(),
           R"(remove(robot) -> bool

Remove the map of a robot. False: the team has no such robot.
)")
      .def_property_readonly("robots", &Team::robots, "Names of the robots, in their order.")
      .def("state", &Team::state, Released(), R"(state() -> Fusion

Return the fusion of all maps that are in the team now. The result does not change afterwards.
)");
}

}  // namespace mrpt_fusion_python
