// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/evaluation.h>

#include "fusion_base/parameter.h"

/** \file
 * The parameters of ranking and verdict in settings files. */

namespace mrpt::fusion {

/** Lists the parameters. They refer to the fields of \a params, which must outlive the result. */
Parameters parametersOf(RankingParams& params);
/** \overload
 * Lists the parameters except the verdict model, which has its own section. */
Parameters parametersOf(EvaluationParams& params);
/** \overload
 * Lists the coefficients of the verdict model in verdict_model.ini. */
Parameters parametersOf(VerdictModel& model);

}  // namespace mrpt::fusion
