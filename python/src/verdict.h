// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/alignment.h>
#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "poses.h"

/** \file
 * The verdict on a match, as properties of classes of Python. */

namespace mrpt_fusion_python {

/** Adds the verdict to a class of Python.
 * \param[in] verdict_of Returns a pointer to the mrpt::fusion::Evaluation of an object of the
 * class. Null for a map that has no match: its figures are None. The class says itself whether its
 * pose is accepted. */
template <class Class, class VerdictOf>
void addVerdict(Class& type, VerdictOf verdict_of) {
  using Evaluation = mrpt::fusion::Evaluation;
  const auto addOr = [&](const char* name, auto without_match, auto get, const char* doc) {
    type.def_property_readonly(
        name,
        [=](const typename Class::type& self) -> decltype(without_match) {
          const Evaluation* e = verdict_of(self);
          if (!e) return without_match;
          return get(*e);
        },
        doc);
  };
  const auto add = [&](const char* name, auto get, const char* doc) {
    using Figure = decltype(get(std::declval<const Evaluation&>()));
    addOr(name, std::optional<Figure>(), get, doc);
  };
  addOr(
      "ambiguous", false, [](const Evaluation& e) { return e.is_ambiguous; },
      "True if another pose fits nearly as well, and nothing else is wrong.");
  addOr(
      "reasons", std::vector<std::string>(), [](const Evaluation& e) { return e.reasons; },
      "Reasons of the verdict: a list of sentences, first all reasons against the pose.");
  addOr(
      "reasons_against", size_t{0}, [](const Evaluation& e) { return e.reasons_against; },
      "Number of the first reasons that speak against the pose or name lacking evidence.");
  addOr(
      "against", std::vector<std::string>(), [](const Evaluation& e) { return e.against(); },
      "Reasons that speak against the pose or name lacking evidence: a list of sentences.");
  add(
      "probability", [](const Evaluation& e) { return e.probability; },
      "Probability that the pose is right: within 0.6 m and 6 deg.");
  add(
      "overlap", [](const Evaluation& e) { return e.overlap; },
      "Overlap: mean share of matched voxels in both maps, in [0,1].");
  add(
      "inlier_ratio", [](const Evaluation& e) { return e.inlier_ratio; },
      "Share of the pairs of voxels that are near each other, in [0,1].");
  add(
      "conflict_ratio", [](const Evaluation& e) { return e.free_space.conflictRatio(); },
      "Share of the obstacles that lie in the free space of the other map, those at its border in "
      "part, in [0,1].");
  addOr(
      "runner_up", std::optional<double>(),
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
