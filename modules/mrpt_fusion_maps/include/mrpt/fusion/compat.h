// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/version.h>

#include <memory>

#if MRPT_VERSION >= 0x030000
#include <mrpt/viz/COctoMapVoxels.h>
#include <mrpt/viz/CSetOfLines.h>
#include <mrpt/viz/CSetOfObjects.h>
#include <mrpt/viz/Scene.h>
#else
#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/opengl/COpenGLScene.h>
#include <mrpt/opengl/CSetOfLines.h>
#include <mrpt/opengl/CSetOfObjects.h>
#endif

/** \file
 * All differences between the versions of MRPT. This library is tested with 2.5.8. The branches for
 * later versions follow their sources and change logs. No other file depends on the version.
 */

namespace mrpt::maps {
class CMetricMap;
}

namespace mrpt::fusion {

#if MRPT_VERSION >= 0x030000
using Scene = mrpt::viz::Scene;
#else
namespace viz = mrpt::opengl;  // MRPT 3 draws with mrpt::viz
/** The contents of a `.3Dscene` file. */
using Scene = mrpt::opengl::COpenGLScene;
#endif

#if MRPT_VERSION >= 0x020b03
using CreatedMap = std::shared_ptr<mrpt::maps::CMetricMap>;
#else
/** The result of `internal_CreateFromMapDefinition()`: a shared_ptr from 2.11.3 on. */
using CreatedMap = mrpt::maps::CMetricMap*;
#endif

/** Transfers the ownership of a new map to MRPT. */
template <class Map>
CreatedMap createdMap(std::unique_ptr<Map> map) {
#if MRPT_VERSION >= 0x020b03
  return map;
#else
  return map.release();
#endif
}

}  // namespace mrpt::fusion
