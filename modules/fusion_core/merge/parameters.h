// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/merging.h>

#include "fusion_base/parameter.h"

/** \file
 * The parameters of merging in settings files. */

namespace mrpt::fusion {

/** Lists the parameters. They refer to the fields of \a params, which must outlive the result. */
Parameters parametersOf(MergeParams& params);

}  // namespace mrpt::fusion
