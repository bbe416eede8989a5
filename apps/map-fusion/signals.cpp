// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Removes temporary files when a signal ends the program. */

#include "signals.h"

#include <csignal>

#include "fusion_base/files.h"
#include "mrpt_maps.h"

namespace map_fusion {

namespace {

extern "C" void endBySignal(int signal) {
  mrpt::fusion::removeTemporaryFiles();
  if (const MrptMaps* maps = loadedMrptMaps()) maps->removeTemporaryFiles();
  // SA_RESETHAND: the signal has its usual effect, when this function has returned.
  ::raise(signal);
}

}  // namespace

void handleSignals() {
  ::signal(SIGXFSZ, SIG_IGN);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction old {};
    if (::sigaction(number, nullptr, &old) != 0 || old.sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = endBySignal;
    action.sa_flags = SA_RESETHAND;
    ::sigaction(number, &action, nullptr);
  }
}

}  // namespace map_fusion
