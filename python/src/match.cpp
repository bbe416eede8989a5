// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Matches two maps, and judges a pose. */

#include <mrpt/core/format.h>
#include <pybind11/stl.h>

#include <sstream>

#include "bindings.h"
#include "poses.h"
#include "results.h"
#include "verdict.h"

namespace mrpt_fusion_python {

Match matchPair(MapPtr a, MapPtr b, const mrpt::fusion::Prior& prior, const Settings& settings) {
  Match match{"match", std::move(a), std::move(b), settings};
  if (!prior.isNone()) match.guess = prior.guess();
  match.alignment = mrpt::fusion::align(match.a->prepared(settings), match.b->prepared(settings),
                                        prior, settings.options);
  return match;
}

namespace {

Match matchMaps(const py::object& a, const py::object& b, const py::object& guess,
                const py::object& sigma, const py::object& options) {
  const Settings settings = settingsOf(options);
  const mrpt::fusion::Prior prior = priorOf(guess, sigma);
  const MapPtr map_a = mapOf(a), map_b = mapOf(b);
  const py::gil_scoped_release release;
  return matchPair(map_a, map_b, prior, settings);
}

Match evaluatePose(const py::object& a, const py::object& b, const py::object& pose,
                   const py::object& options) {
  Match match{"evaluate", mapOf(a), mapOf(b), settingsOf(options)};
  const auto T_a_b = mrpt::fusion::toPose(poseOf(pose, "pose"));
  const py::gil_scoped_release release;
  match.alignment =
      mrpt::fusion::evaluate(match.a->prepared(match.settings), match.b->prepared(match.settings),
                             T_a_b, match.settings.options);
  return match;
}

std::string textOf(const Match& match) {
  const auto& e = match.alignment.evaluation;
  std::ostringstream out;
  out << "<mrpt_fusion.Match, "
      << (e.accepted       ? "accepted"
          : e.is_ambiguous ? "ambiguous"
                           : "rejected")
      << ", probability " << e.probability << ">";
  return out.str();
}

std::string textOf(const mrpt::fusion::RankedPose& hypothesis) {
  const auto p = mrpt::fusion::toPose(hypothesis.T_a_b);
  return mrpt::format(
      "<mrpt_fusion.Hypothesis, agreement %g, at (%.2f, %.2f, %.2f) m, yaw %.1f deg>",
      hypothesis.agreement, p.x(), p.y(), p.z(), mrpt::RAD2DEG(p.yaw()));
}

}  // namespace

void bindMatch(py::module_& m) {
  using mrpt::fusion::RankedPose;
  py::class_<RankedPose>(m, "Hypothesis",
                         "A pose of map B in A's frame that was compared with others.")
      .def_property_readonly(
          "pose", [](const RankedPose& p) { return arrayOf(p.T_a_b); }, "4x4 pose of map B, m.")
      .def_readonly("agreement", &RankedPose::agreement, "Agreement of the maps at the pose.")
      .def_property_readonly(
          "covariance", [](const RankedPose& p) { return arrayOf(p.covariance); },
          "6x6 covariance, see Match.covariance.")
      .def("__repr__", py::overload_cast<const RankedPose&>(&textOf));

  py::class_<Match> match(m, "Match", R"(The pose of map B in the frame of map A, and its verdict.

p_a = pose @ p_b. match() and evaluate() return it.
)");
  match
      .def_property_readonly(
          "pose", [](const Match& self) { return arrayOf(self.alignment.match.T_a_b); },
          "4x4 pose of map B in A's frame, m.")
      .def_property_readonly(
          "covariance", [](const Match& self) { return arrayOf(self.alignment.match.covariance); },
          "6x6 covariance of a small motion after the pose, in A's frame: translation (m), "
          "rotation "
          "(rad).")
      .def_property_readonly(
          "hypotheses", [](const Match& self) { return self.alignment.match.hypotheses; },
          "Poses that were compared, best first: a list of Hypothesis.")
      .def_property_readonly(
          "by_edges", [](const Match& self) { return self.alignment.by_edges; },
          "True if only edges were compared. Such a match is never accepted.")
      .def_property_readonly(
          "accepted", [](const Match& self) { return self.alignment.evaluation.accepted; },
          "True if the pose can be trusted.")
      .def("__repr__", py::overload_cast<const Match&>(&textOf));
  addVerdict(match, [](const Match& self) { return &self.alignment.evaluation; });

  m.def("match", &matchMaps, py::arg("a"), py::arg("b"), py::arg("guess") = py::none(),
        py::arg("guess_sigma") = py::none(), py::arg("options") = py::dict(),
        R"(match(a, b, guess=None, guess_sigma=None, options={}) -> Match

Estimate the pose of map B in the frame of map A, and judge whether it is right.

a, b: a Map, or the path of a file. guess: 4x4 pose of B in A's frame. Without a guess, B is searched
everywhere and at any heading. guess_sigma: standard deviations of the guess: position (m) and
heading (deg). The search covers 3 standard deviations. options: see default_options(), or the path
of an .ini file. The result does not depend on the number of threads.

>>> m = mf.match('a.ot', 'b.ot')
>>> m.accepted, m.probability > 0.95
(True, True)
>>> m.pose[:2, 3].round(1).tolist()
[31.3, 0.1]
>>> mf.match('a.ot', 'b.ot', guess=m.pose, guess_sigma=(0.5, 5)).accepted
True
)");
  m.def("evaluate", &evaluatePose, py::arg("a"), py::arg("b"), py::arg("pose"),
        py::arg("options") = py::dict(),
        R"(evaluate(a, b, pose, options={}) -> Match

Judge whether a given 4x4 pose of map B in A's frame is right. The pose stays as it is.

>>> import numpy
>>> mf.evaluate('a.ot', 'b.ot', numpy.eye(4)).accepted
False
)");
}

}  // namespace mrpt_fusion_python
