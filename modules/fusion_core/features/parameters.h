// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/prepared_map.h>

#include "fusion_base/parameter.h"

/** \file
 * The parameters of the features stage, as settings files have them. */

namespace mrpt::fusion {

/** Refers to the fields of \a params, which must outlive the result. */
Parameters parametersOf(FeatureParams& params);

}  // namespace mrpt::fusion
