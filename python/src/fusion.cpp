// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Fuses two or more maps. */

#include <pybind11/stl.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "bindings.h"
#include "fusion_base/error_text.h"
#include "fusion_base/file_names.h"
#include "poses.h"
#include "results.h"
#include "verdict.h"

using mrpt::fusion::FusionMember;
using mrpt::fusion::TeamPair;

namespace mrpt_fusion_python {

bool Fusion::isAccepted() const {
  if (match) return match->alignment.evaluation.accepted;
  return map && std::all_of(members.begin(), members.end(), [](const FusionMember& m) {
           return m.alignment.by_edges || !m.hasMatch() || m.alignment.evaluation.accepted;
         });
}

namespace {

using Poses = std::map<std::string, DoubleArray>;

/** Names robots by the folders of their files, too, if files have the same name. */
void nameByFolders(std::vector<Robot>& robots) {
  std::vector<std::string> paths;
  for (const Robot& robot : robots) {
    const std::string& path = robot.map->origin().path;
    paths.push_back(path.empty() ? robot.name : path);
  }
  const std::vector<std::string> names = mrpt::fusion::namesOf(paths);
  for (size_t i = 0; i < robots.size(); i++)
    if (!robots[i].map->origin().path.empty()) robots[i].name = names[i];
}

/** Returns the file of a map; empty if it has none. */
std::string fileOf(const py::handle& map) {
  if (py::isinstance<Map>(map)) return map.cast<std::shared_ptr<Map>>()->origin().path;
  return pathOf(py::reinterpret_borrow<py::object>(map));
}

/** Returns whether two maps are the same object, or come from the same file. */
bool areSame(const py::handle& a, const py::handle& b) {
  if (a.is(b)) return true;
  const std::string file_a = fileOf(a), file_b = fileOf(b);
  return !file_a.empty() && !file_b.empty() && mrpt::fusion::isSameFile(file_a, file_b);
}

/** Returns the maps of a list, each once. Warns of all others. */
std::vector<py::object> distinct(const py::iterable& maps) {
  std::vector<py::object> distinct;
  size_t index = 0;
  for (const py::handle map : maps) {
    const bool is_known = std::any_of(distinct.begin(), distinct.end(),
                                      [&](const py::object& other) { return areSame(map, other); });
    if (!is_known) {
      distinct.push_back(py::reinterpret_borrow<py::object>(map));
    } else {
      const std::string file = fileOf(map);
      warn((file.empty() ? "maps[" + std::to_string(index) + "]" : file) +
           ": is given twice, and counts once");
    }
    index++;
  }
  return distinct;
}

/** Returns the robots of a list of maps. A map and itself are two robots, as for map-fusion. */
std::vector<Robot> robotsOfList(const py::iterable& maps) {
  const auto given = py::list(maps);
  std::vector<Robot> robots;
  for (const py::object& map : distinct(given)) {
    const MapPtr loaded = mapOf(map);
    const std::string& name = loaded->origin().name;
    robots.push_back({name.empty() ? "map" + std::to_string(robots.size()) : name, loaded});
  }
  nameByFolders(robots);
  if (robots.size() == 1 && given.size() == 2)
    robots.push_back({robots[0].name + "_again", robots[0].map});
  return robots;
}

/** \exception pybind11::type_error If the maps are neither a list nor a dict. */
void checkMaps(const py::object& maps) {
  if (py::isinstance<py::str>(maps) || py::isinstance<py::bytes>(maps) ||
      !py::isinstance<py::iterable>(maps))
    throw py::type_error("maps is a list or a dict: fuse([a, b])");
}

/** Returns the robots of a dict of maps by name, or of a list of maps. */
std::vector<Robot> robotsOf(const py::object& maps) {
  std::vector<Robot> robots;
  if (py::isinstance<py::dict>(maps)) {
    for (const auto& [name, map] : py::reinterpret_borrow<py::dict>(maps))
      robots.push_back({name.cast<std::string>(), mapOf(py::reinterpret_borrow<py::object>(map))});
  } else {
    robots = robotsOfList(maps);
  }
  std::set<std::string> names;
  for (const Robot& robot : robots)
    if (!names.insert(robot.name).second)
      throw py::value_error("two maps are named '" + robot.name + "': give a dict of maps");
  if (robots.size() < 2) throw py::value_error("a fusion needs at least two maps");
  return robots;
}

Fusion fusePair(const std::vector<Robot>& robots, const mrpt::fusion::Prior& prior,
                const Settings& settings) {
  Fusion fusion{robots, settings, nullptr};
  fusion.match = matchPair(robots[0].map, robots[1].map, prior, settings);
  if (!fusion.isAccepted()) return fusion;
  fusion.merged = mergePair(*robots[0].map, *robots[1].map, fusion.match->alignment.match.T_a_b,
                            settings, false);
  fusion.map = fusion.merged->map;
  return fusion;
}

Fusion fuseTeam(const std::vector<Robot>& robots,
                const std::map<std::string, Eigen::Isometry3d>& poses, const Settings& settings) {
  std::vector<mrpt::fusion::RobotMap> maps;
  for (const Robot& robot : robots) {
    const auto pose = poses.find(robot.name);
    mrpt::fusion::withPath(robot.name, [&] {
      maps.push_back({robot.name, robot.map->prepared(settings),
                      pose == poses.end()
                          ? robot.map->origin().pose
                          : mrpt::poses::CPose3DPDFGaussian(mrpt::fusion::toPose(pose->second))});
    });
  }
  auto result = mrpt::fusion::fuseMaps(maps, settings.options);
  Fusion fusion{robots, settings, nullptr};
  fusion.members = std::move(result.members);
  fusion.pairs = std::move(result.pairs);
  const auto joined = std::count_if(fusion.members.begin(), fusion.members.end(),
                                    [](const FusionMember& m) { return m.joined; });
  if (joined > 1) fusion.map = mapOf(std::move(result.map), std::move(result.sources));
  return fusion;
}

Fusion fuse(const py::object& maps, const py::object& guess, const py::object& sigma,
            const Poses& poses, const py::object& options, bool independent) {
  checkMaps(maps);  // in fuse(a, b), b is no guess
  Settings settings = settingsOf(options);
  settings.options.merge.independent = independent;
  const mrpt::fusion::Prior prior = priorOf(guess, sigma);
  const std::vector<Robot> robots = robotsOf(maps);
  std::map<std::string, Eigen::Isometry3d> known;
  for (const auto& [name, pose] : poses) {
    const std::string& robot = name;
    if (std::none_of(robots.begin(), robots.end(), [&](const Robot& r) { return r.name == robot; }))
      throw py::value_error("poses: there is no map '" + name + "'");
    known[name] = poseOf(pose);
  }
  const bool is_pair =
      robots.size() == 2 && known.empty() &&
      std::none_of(robots.begin(), robots.end(), [](const Robot& r) {
        return r.map->isEdgesAlone() || !mrpt::fusion::Prior(r.map->origin().pose).isNone();
      });
  if (!guess.is_none() && !is_pair)
    throw py::value_error("guess is for two maps; give poses of more maps");
  const py::gil_scoped_release release;
  return is_pair ? fusePair(robots, prior, settings) : fuseTeam(robots, known, settings);
}

/** Returns the poses of all placed robots in the frame of the fused map. */
py::dict posesOf(const Fusion& fusion) {
  py::dict poses;
  if (fusion.match && fusion.map) {
    poses[py::str(fusion.robots[0].name)] =
        arrayOf(Eigen::Isometry3d(Eigen::Isometry3d::Identity()));
    poses[py::str(fusion.robots[1].name)] = arrayOf(fusion.match->alignment.match.T_a_b);
  }
  for (const FusionMember& m : fusion.members)
    if (m.joined) poses[py::str(m.robot)] = arrayOf(mrpt::fusion::toEigen(m.pose.mean));
  return poses;
}

/** Adds the reasons of the maps of a team against their places, or those for their places. */
void addReasons(const Fusion& fusion, bool against, std::vector<std::string>& reasons) {
  for (const FusionMember& m : fusion.members) {
    const auto& e = m.alignment.evaluation;
    for (size_t i = 0; i < e.reasons.size(); i++)
      if ((i < e.reasons_against) == against) reasons.push_back(m.robot + ": " + e.reasons[i]);
  }
}

std::vector<std::string> reasonsOf(const Fusion& fusion) {
  if (fusion.match) return fusion.match->alignment.evaluation.reasons;
  std::vector<std::string> reasons;
  addReasons(fusion, true, reasons);
  addReasons(fusion, false, reasons);
  return reasons;
}

std::vector<std::string> reasonsAgainst(const Fusion& fusion) {
  if (fusion.match) return fusion.match->alignment.evaluation.against();
  std::vector<std::string> reasons;
  addReasons(fusion, true, reasons);
  return reasons;
}

std::string textOf(const Fusion& fusion) {
  std::ostringstream out;
  out << "<mrpt_fusion.Fusion of " << fusion.robots.size() << " maps, "
      << (fusion.isAccepted() ? "accepted>"
          : fusion.map        ? "some maps are left out>"
                              : "rejected>");
  return out.str();
}

std::string textOf(const FusionMember& member) {
  std::ostringstream out;
  out << "<mrpt_fusion.Member '" << member.robot << "', "
      << (member.joined ? "joined" : "not joined");
  if (member.hasMatch())
    out << ", matched with '" << member.matched_with << "', probability "
        << member.alignment.evaluation.probability;
  out << ">";
  return out.str();
}

std::string textOf(const TeamPair& pair) {
  std::ostringstream out;
  out << "<mrpt_fusion.Pair '" << pair.a << "', '" << pair.b << "', "
      << (pair.holds ? "holds" : "does not hold") << ", probability " << pair.probability << ">";
  return out.str();
}

const char* nameOf(mrpt::fusion::Counting counting) {
  static constexpr const char* kNames[] = {"all", "unknown_space", "none", "copy"};
  return kNames[static_cast<size_t>(counting)];
}

void bindMember(py::module_& m) {
  py::class_<FusionMember> member(
      m, "Member",
      "The result for one robot's map in a team. The first map keeps its "
      "frame and has no match: its probability and all other figures of "
      "a match are None.");
  member.def_readonly("robot", &FusionMember::robot, "Name of the robot.")
      .def_readonly("joined", &FusionMember::joined, "True if the map is part of the fused map.")
      .def_property_readonly(
          "pose",
          [](const FusionMember& self) { return arrayOf(mrpt::fusion::toEigen(self.pose.mean)); },
          "4x4 pose in the frame of the fused map, m. It is trusted if the map has joined.")
      .def_property_readonly(
          "covariance", [](const FusionMember& self) { return covarianceArrayOf(self.pose); },
          "6x6 covariance of the pose, see Match.covariance. In a team: the joint covariance from "
          "all matches that hold the map.")
      .def_readonly("matched_with", &FusionMember::matched_with,
                    "Robot whose map is map A of the match; '' for the first map.")
      .def_readonly("fits", &FusionMember::fits,
                    "Robots whose maps fit this map, if they hold together without the first map.")
      .def_property_readonly(
          "counting", [](const FusionMember& self) { return nameOf(self.counting); },
          "How the map counts in the fused map: 'all', 'unknown_space', 'none' or 'copy'.")
      .def_property_readonly(
          "accepted",
          [](const FusionMember& self) {
            return self.hasMatch() ? self.alignment.evaluation.accepted : self.joined;
          },
          "True if the pose can be trusted. A map without a match, such as the first map: if it "
          "has joined.")
      .def("__repr__", py::overload_cast<const FusionMember&>(&textOf));
  addVerdict(member, [](const FusionMember& self) {
    return self.hasMatch() ? &self.alignment.evaluation : nullptr;
  });
  py::class_<TeamPair>(m, "Pair", "The match of two maps of a team.")
      .def_readonly("a", &TeamPair::a, "Robot whose map is map A.")
      .def_readonly("b", &TeamPair::b, "Robot whose map is map B.")
      .def_readonly("accepted", &TeamPair::accepted, "True if the match would be accepted alone.")
      .def_readonly("ambiguous", &TeamPair::ambiguous, "See Match.ambiguous.")
      .def_readonly("probability", &TeamPair::probability, "See Match.probability.")
      .def_readonly("overlap", &TeamPair::overlap, "See Match.overlap.")
      .def_readonly("holds", &TeamPair::holds,
                    "True if both maps lie at the pose of the match in the fused map.")
      .def("__repr__", py::overload_cast<const TeamPair&>(&textOf));
}

/** Adds a property of the match of two maps; None for a team. */
template <class Class, class Get>
void addOfPair(Class& type, const char* name, Get get, const char* doc) {
  type.def_property_readonly(
      name,
      [get](const Fusion& self) -> py::object {
        if (!self.match) return py::none();
        return get(self.match->alignment);
      },
      doc);
}

}  // namespace

void bindFusion(py::module_& m) {
  bindMember(m);
  using mrpt::fusion::Alignment;
  py::class_<Fusion, std::shared_ptr<Fusion>> fusion(m, "Fusion", "The result of fuse().");
  fusion
      .def_property_readonly("accepted", &Fusion::isAccepted,
                             "True if all maps are in the fused map. Maps that have only edges do "
                             "not count.")
      .def_property_readonly(
          "map", [](const Fusion& self) { return toPython(self.map); },
          "Fused map in the frame of the first map. None if nothing was merged.")
      .def_property_readonly("poses", &posesOf,
                             "4x4 poses of all placed maps in the frame of the fused map: a dict.")
      .def_property_readonly("reasons", &reasonsOf,
                             "Reasons of the verdict: a list of sentences, first all reasons "
                             "against the poses. In a team they begin with the name of the robot.")
      .def_property_readonly(
          "reasons_against", [](const Fusion& self) { return reasonsAgainst(self).size(); },
          "Number of the first reasons that speak against the poses or name lacking evidence.")
      .def_property_readonly("against", &reasonsAgainst,
                             "Reasons that speak against the poses or name lacking evidence: a "
                             "list of sentences.")
      .def_readonly("match", &Fusion::match, "Match of two maps. None for a team.")
      .def_readonly("members", &Fusion::members,
                    "Results of all maps of a team: a list of Member. Empty for two maps.")
      .def_readonly("pairs", &Fusion::pairs,
                    "Matches of all pairs of a team: a list of Pair. Empty for two maps.")
      .def("__repr__", py::overload_cast<const Fusion&>(&textOf));
  addOfPair(
      fusion, "pose", [](const Alignment& a) { return arrayOf(a.match.T_a_b); },
      "4x4 pose of the second of two maps in the frame of the first, m. None for a team: see "
      "poses.");
  addOfPair(
      fusion, "covariance", [](const Alignment& a) { return arrayOf(a.match.covariance); },
      "6x6 covariance of pose, see Match.covariance. None for a team.");
  addOfPair(
      fusion, "probability",
      [](const Alignment& a) { return py::float_(a.evaluation.probability); },
      "Probability that pose is right. None for a team: see members.");

  m.def(
      "fuse", &fuse, py::arg("maps"), py::arg("guess") = py::none(),
      py::arg("guess_sigma") = py::none(), py::arg("poses") = py::dict(),
      py::arg("options") = py::dict(), py::kw_only(), py::arg("independent") = false,
      R"(fuse(maps, guess=None, guess_sigma=None, poses={}, options={}, *, independent=False) -> Fusion

Fuse two or more maps, as far as their matches can be trusted.

maps: a list of Maps or paths, or a dict of them by name. The first map keeps its frame. guess,
guess_sigma: the guess of the pose of the second of two maps, see match(). poses: for more maps,
guesses of their 4x4 poses in a common frame: a dict by the name of the map. options: see
default_options(). independent: if True, all observations of all maps count; otherwise no observation
counts twice. A map that is twice in a list counts once, with a warning.

>>> r = mf.fuse(['a.ot', 'b.ot'])
>>> r
<mrpt_fusion.Fusion of 2 maps, accepted>
>>> r.map.save('fused.ot')
>>> sorted(r.poses)
['a', 'b']
)");
}

}  // namespace mrpt_fusion_python
