// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/evaluation.h>

#include "fusion_base/parameter.h"

/** \file
 * The parameters of ranking and verdict, as settings files have them. */

namespace mrpt::fusion {

/** Refers to the fields of \a params, which must outlive the result. */
Parameters parametersOf(RankingParams& params);
/** \overload
 * Without the model, which has a section of its own. */
Parameters parametersOf(EvaluationParams& params);
/** \overload
 * The coefficients, as verdict_model.ini has them. */
Parameters parametersOf(VerdictModel& model);

}  // namespace mrpt::fusion
