// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/** \file
 * Sets of maps that MRPT reads. */

namespace mrpt::fusion {

/** Makes MRPT's readers refuse sets of maps that are nested so deep that they would overflow the
 * stack. CMultiMetricMap::serializeFrom() has no bound, and MRPT's programs read files with it. So
 * the factory of the class is replaced by a factory that looks at the stack first. */
void guardSetsOfMaps();

}  // namespace mrpt::fusion
