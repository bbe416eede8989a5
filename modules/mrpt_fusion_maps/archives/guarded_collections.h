// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/** \file
 * Reading of the collections of MRPT. */

namespace mrpt::fusion {

/** Makes MRPT's readers build collections object by object: CMultiMetricMap, CSimpleMap,
 * CSensoryFrame and CActionCollection. MRPT creates as many entries as the stream claims, up to
 * 2^32 of them, before it reads the first object. Also refuses sets of maps that are nested so deep
 * that they would overflow the stack. MRPT's programs read files with these classes, and any object
 * may hold them. So the factories of the classes are replaced. */
void guardCollections();

}  // namespace mrpt::fusion
