// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The Python module mrpt_fusion._core. */

#include "bindings.h"

PYBIND11_MODULE(_core, m) {
  using namespace mrpt_fusion_python;
  // The docstrings begin with the signatures of __init__.pyi: those of C++ say less.
  pybind11::options docstrings;
  docstrings.disable_function_signatures();
  m.attr("__version__") = MRPT_FUSION_VERSION;
  bindError(m);
  bindSettings(m);
  bindMap(m);
  bindFiles(m);
  bindVoxels(m);
  bindInsertion(m);
  bindEdges(m);
  bindMatch(m);
  bindMerge(m);
  bindFusion(m);
  bindTeam(m);
  bindReport(m);
}
