// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/maps/CMetricMap.h>

#include "mrpt_fusion_maps/archives/guarded_archive.h"

/** \file
 * Reading of serialized maps of all classes of MRPT. */

namespace mrpt::fusion {

/** Reads a map of any class after its header. Sets of maps may hold sets of maps, to a depth of 8.
 * The octrees of COctoMap and CColouredOctoMap are read by the parser of this library, because the
 * parser of OctoMap trusts its input. \exception std::exception If the class is unknown or is no
 * map, and if the map is damaged. */
mrpt::maps::CMetricMap::Ptr readMap(GuardedArchive& in, const ObjectHeader& header);

/** Returns whether the class is a map. */
bool isMap(const ObjectHeader& header);

}  // namespace mrpt::fusion
