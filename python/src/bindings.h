// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/pybind11.h>

#include <string>

/** \file
 * The parts of the Python module, in the order of the data flow. Each is one file. */

namespace mrpt_fusion_python {

namespace py = pybind11;

/** Warns as Python does (UserWarning). \exception pybind11::error_already_set If warnings are
 * errors. */
void warn(const std::string& text);

void bindError(py::module_& m);      ///< Error, the exception of this module
void bindSettings(py::module_& m);   ///< default_options()
void bindMap(py::module_& m);        ///< Map
void bindFiles(py::module_& m);      ///< load(), load_mission(), bytes, pickles
void bindVoxels(py::module_& m);     ///< Map from and to numpy
void bindInsertion(py::module_& m);  ///< MapBuilder
void bindEdges(py::module_& m);      ///< edges()
void bindMatch(py::module_& m);      ///< match(), evaluate()
void bindMerge(py::module_& m);      ///< merge()
void bindFusion(py::module_& m);     ///< fuse()
void bindTeam(py::module_& m);       ///< MapTeam
void bindReport(py::module_& m);     ///< Pages and figures of all results

}  // namespace mrpt_fusion_python
