// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Merges two maps at a given pose. */

#include <string>

#include "bindings.h"
#include "poses.h"
#include "results.h"

using mrpt::fusion::Counting;

namespace mrpt_fusion_python {

Merged mergePair(const Map& a, const Map& b, const Eigen::Isometry3d& T_a_b,
                 const Settings& settings, bool is_given) {
  auto merged = mrpt::fusion::mergeSources({a.whole().octree(), a.sources()},
                                           {b.whole().octree(), b.sources()}, T_a_b,
                                           settings.options.merge, is_given);
  return {mapOf(std::move(merged.map), std::move(merged.sources)), {merged.of_a, merged.of_b}};
}

namespace {

void warnOf(const std::string& map, Counting counting) {
  if (counting == Counting::All) return;
  warn("map " + map +
       (counting == Counting::UnknownSpace
            ? " has sources of the other map: it adds only unknown space"
            : " has no source that the other map has not: it adds nothing") +
       " (independent=True counts all)");
}

py::object merge(const py::object& a, const py::object& b, const py::object& pose,
                 const py::object& options, bool independent) {
  Settings settings = settingsOf(options);
  settings.options.merge.independent = independent;
  const Eigen::Isometry3d T_a_b = poseOf(pose, "pose");
  const MapPtr map_a = mapOf(a), map_b = mapOf(b);
  Merged merged;
  {
    const py::gil_scoped_release release;
    merged = mergePair(*map_a, *map_b, T_a_b, settings, true);
  }
  warnOf("A", merged.counting.first);
  warnOf("B", merged.counting.second);
  return toPython(merged.map);
}

}  // namespace

void bindMerge(py::module_& m) {
  m.def("merge", &merge, py::arg("a"), py::arg("b"), py::arg("pose"),
        py::arg("options") = py::dict(), py::kw_only(), py::arg("independent") = false,
        R"(merge(a, b, pose, options={}, *, independent=False) -> Map

Merge two maps at a given 4x4 pose of map B in A's frame, without a verdict. The result is in A's
frame. The option merge_policy is the rule for voxels that both maps know. independent: see fuse().

>>> m = mf.match('a.ot', 'b.ot')
>>> mf.merge('a.ot', 'b.ot', m.pose).to_bytes() == mf.fuse(['a.ot', 'b.ot']).map.to_bytes()
True
)");
}

}  // namespace mrpt_fusion_python
