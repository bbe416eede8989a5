// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "fusion_core/features/features.h"

/** \file
 * What a map looks like, whatever its frame. */

namespace mrpt::fusion {

/** The surroundings of some structural edges of a map, one column each. A column counts the
 * surfaces around an edge, by distance and angles, and has unit length. It does not depend on the
 * frame of the map. The product of two columns is the similarity of two surroundings, [0,1]. */
using Signature = Eigen::MatrixXf;

/** Computes the signature of a map: at most 256 surroundings with a radius of 2 m, spread over the
 * map. Edges with hardly any surface around have no column. Cost: O(256 matched voxels).
 * \param[in] map The map. It may have no edges; the signature then has no columns.
 * \param[in] scale Factor of lengths, see ScaleParams. */
Signature signatureOf(const MapFeatures& map, double scale);

}  // namespace mrpt::fusion
