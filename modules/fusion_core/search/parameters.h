// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/search_params.h>

#include "fusion_base/parameter.h"

/** \file
 * The parameters of the search stage, as settings files have them. */

namespace mrpt::fusion {

/** Refers to the fields of \a params, which must outlive the result. */
Parameters parametersOf(SearchParams& params);

}  // namespace mrpt::fusion
