// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/maps/COctoMap.h>
#include <mrpt/serialization/CArchive.h>

#include <cstdint>
#include <cstring>

/** \file
 * Flags in the archives of MRPT. MRPT copies a byte of the stream into a bool. A bool with a byte
 * other than 0 and 1 has undefined behaviour, so each flag is checked before its first use. */

namespace mrpt::fusion {

/** Checks flags that were read from a stream.
 * \exception std::exception If the byte of a flag is not 0 or 1. */
template <class... Flags>
void checkFlags(const bool& flag, const Flags&... flags) {
  uint8_t byte = 0;
  std::memcpy(&byte, &flag, sizeof(byte));
  if (byte > 1) THROW_EXCEPTION("corrupt stream: a flag is neither true nor false");
  if constexpr (sizeof...(flags) > 0) checkFlags(flags...);
}

/** \overload */
inline void checkFlags(const mrpt::maps::TMapGenericParams& params) {
  checkFlags(params.enableSaveAs3DObject, params.enableObservationLikelihood,
             params.enableObservationInsertion);
}

/** \overload
 * For the rendering options of MRPT's octomaps. */
template <class RenderingOptions,
          class = decltype(std::declval<RenderingOptions>().generateGridLines)>
void checkFlags(const RenderingOptions& o) {
  checkFlags(o.generateGridLines, o.generateOccupiedVoxels, o.visibleOccupiedVoxels,
             o.generateFreeVoxels, o.visibleFreeVoxels);
}

}  // namespace mrpt::fusion
