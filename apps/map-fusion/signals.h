// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/** \file
 * What signals do to a run. */

namespace map_fusion {

/** Makes SIGINT, SIGTERM and SIGHUP remove the temporary files before they end the program. A file
 * that grows too large (SIGXFSZ) becomes an error of writing. Signals that the caller of the
 * program ignores stay ignored. */
void handleSignals();

}  // namespace map_fusion
