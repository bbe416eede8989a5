// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/registration_params.h>

#include "fusion_base/parameter.h"

/** \file
 * The parameters of the registration stage in settings files. */

namespace mrpt::fusion {

/** Lists the parameters. They refer to the fields of \a params, which must outlive the result. */
Parameters parametersOf(RegistrationParams& params);

}  // namespace mrpt::fusion
