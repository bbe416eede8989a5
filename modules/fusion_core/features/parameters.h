// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/prepared_map.h>

#include "fusion_base/parameter.h"

/** \file
 * The parameters of the features stage in settings files. */

namespace mrpt::fusion {

/** Lists the parameters. They refer to the fields of \a params, which must outlive the result. */
Parameters parametersOf(FeatureParams& params);

/** Returns the parameters with all lengths multiplied by \a scale. */
FeatureParams scaledBy(FeatureParams params, double scale);

}  // namespace mrpt::fusion
