// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Removes temporary files when a signal or a lack of memory ends the program. */

#include "signals.h"

#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <exception>
#include <new>
#include <string_view>

#include "arguments.h"
#include "fusion_base/files.h"
#include "mrpt_maps.h"

namespace map_fusion {

namespace {

void removeTemporaryFiles() noexcept {
  mrpt::fusion::removeTemporaryFiles();
  if (const MrptMaps* maps = loadedMrptMaps()) maps->removeTemporaryFiles();
}

extern "C" void endBySignal(int signal) {
  removeTemporaryFiles();
  // SA_RESETHAND: the signal has its usual effect, when this function has returned.
  ::raise(signal);
}

volatile std::sig_atomic_t stop_wanted = 0;

extern "C" void wantStop(int) { stop_wanted = 1; }

std::terminate_handler usual_end = nullptr;

[[noreturn]] void endByException() {
  try {
    if (std::current_exception()) throw;
  } catch (const std::bad_alloc&) {
    removeTemporaryFiles();
    constexpr std::string_view kMessage = "map-fusion: out of memory\n";
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, kMessage.data(), kMessage.size());
    std::_Exit(kFailure);
  } catch (...) {  // a fault of the program
  }
  usual_end();
  std::abort();
}

}  // namespace

void handleLackOfMemory() { usual_end = std::set_terminate(endByException); }

void stopAtSignals() {
  struct sigaction action {};
  action.sa_handler = wantStop;
  for (const int number : {SIGINT, SIGTERM}) ::sigaction(number, &action, nullptr);
}

bool stopWanted() { return stop_wanted != 0; }

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
