// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/options.h>

/** \file
 * The options at the scale of a pair. */

namespace mrpt::fusion {

/** Returns the options with all lengths multiplied by \a scale, see ScaleParams. */
Options scaledBy(Options options, double scale);

}  // namespace mrpt::fusion
