// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/alignment.h>
#include <pybind11/stl.h>

#include <optional>

#include "poses.h"

/** \file
 * The verdict on a match, as properties of classes of Python. */

namespace mrpt_fusion_python {

/** Adds the verdict to a class of Python.
 * \param[in] verdict_of Returns the mrpt::fusion::Evaluation of an object of the class. */
template <class Class, class VerdictOf>
void addVerdict(Class& type, VerdictOf verdict_of) {
  const auto add = [&](const char* name, auto get, const char* doc) {
    type.def_property_readonly(
        name, [=](const typename Class::type& self) { return get(verdict_of(self)); }, doc);
  };
  using Evaluation = mrpt::fusion::Evaluation;
  add(
      "accepted", [](const Evaluation& e) { return e.accepted; },
      "True if the pose can be trusted.");
  add(
      "ambiguous", [](const Evaluation& e) { return e.is_ambiguous; },
      "True if another pose fits nearly as well, and nothing else is wrong.");
  add(
      "probability", [](const Evaluation& e) { return e.probability; },
      "Probability that the pose is right: within 0.6 m and 6 deg.");
  add(
      "reasons", [](const Evaluation& e) { return e.reasons; },
      "Reasons of the verdict: a list of sentences, first all reasons against the pose.");
  add(
      "reasons_against", [](const Evaluation& e) { return e.reasons_against; },
      "Number of the first reasons that speak against the pose or name lacking evidence.");
  add(
      "overlap", [](const Evaluation& e) { return e.overlap; },
      "Overlap: mean share of matched voxels in both maps, in [0,1].");
  add(
      "inlier_ratio", [](const Evaluation& e) { return e.inlier_ratio; },
      "Share of the pairs of voxels that are near each other, in [0,1].");
  add(
      "conflict_ratio", [](const Evaluation& e) { return e.free_space.conflictRatio(); },
      "Share of the obstacles that lie in the free space of the other map, in [0,1].");
  add(
      "runner_up",
      [](const Evaluation& e) {
        return e.other_poses == mrpt::fusion::OtherPoses::Compared ? std::optional(e.runner_up)
                                                                   : std::nullopt;
      },
      "Agreement of the best other pose over the agreement of this pose. None if no other pose was "
      "compared.");
  add(
      "deviation",
      [](const Evaluation& e) {
        return std::make_pair(e.deviation.translation, mrpt::RAD2DEG(e.deviation.rotation));
      },
      "Standard deviations of the pose in its least certain directions: m, deg.");
}

}  // namespace mrpt_fusion_python
