// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Registers the classes of this library. */

#include <mrpt/core/initializer.h>
#include <mrpt/maps/CEdgeVoxelMap.h>
#include <mrpt/maps/CProbOctoMap.h>
#include <mrpt/obs/CObservationLocalMap.h>
#include <mrpt/rtti/CObject.h>

#include "mrpt_fusion_maps/archives/guarded_collections.h"

/** Registers the classes in MRPT when the library is loaded, as a linked library or as a plugin. */
MRPT_INITIALIZER(registerFusionMaps) {
  mrpt::rtti::registerClass(CLASS_ID(mrpt::maps::CEdgeVoxelMap));
  mrpt::rtti::registerClass(CLASS_ID(mrpt::maps::CProbOctoMap));
  mrpt::rtti::registerClass(CLASS_ID(mrpt::obs::CObservationLocalMap));
  mrpt::rtti::registerClass(CLASS_ID(mrpt::obs::CObservationMapDiff));
  mrpt::fusion::guardCollections();
}
