// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * A library for LD_PRELOAD. It sends a signal to a program while the program writes a file. */

#include <unistd.h>

#include <csignal>
#include <cstdlib>

/** Replaces the system's function, which a program calls after it has written the bytes of a file
 * and before it gives the file its name. The variable SIGNAL_AT_FSYNC has the number of the signal.
 */
extern "C" int fsync(int file) {
  if (const char* number = std::getenv("SIGNAL_AT_FSYNC")) ::raise(std::atoi(number));
  return ::fdatasync(file);
}
