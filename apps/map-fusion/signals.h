// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/** \file
 * How a run ends before its time. */

namespace map_fusion {

/** Makes SIGINT, SIGTERM and SIGHUP remove the temporary files before they end the program. A file
 * that grows too large (SIGXFSZ) becomes an error of writing. Signals that the caller of the
 * program ignores stay ignored. */
void handleSignals();

/** Makes SIGINT and SIGTERM end the run in order: they only set what stopWanted() returns. */
void stopAtSignals();
/** Returns whether one of these signals has come. */
bool stopWanted();

/** Makes std::bad_alloc end the program as a failure, with one line, where no function can catch
 * it: in constructors of libraries that are being loaded, and in functions that must not throw. */
void handleLackOfMemory();

}  // namespace map_fusion
