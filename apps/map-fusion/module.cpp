// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Loads modules: libraries that only some runs need. */

#include "module.h"

#include <dlfcn.h>

#include <new>
#include <stdexcept>

namespace map_fusion {

namespace {

/** Throws the reason why the module cannot be loaded. */
[[noreturn]] void throwLoadError(const std::string& contents) {
  const char* error = ::dlerror();
  const std::string reason = error ? error : "cannot be loaded";
  // The loader of the system has words, no error codes. "TLS" is a limit of the loader itself.
  const auto says = [&](const char* words) { return reason.find(words) != std::string::npos; };
  if ((says("failed to map segment") || says("cannot map") || says("annot allocate") ||
       says("cannot create")) &&
      !says("static TLS"))
    throw std::bad_alloc();
  throw std::runtime_error(contents + ": " + reason);
}

}  // namespace

void* functionOfModule(const char* file, const char* name, const std::string& contents) {
  void* module = ::dlopen(file, RTLD_LAZY);  // searched in the run path of this program
  void* function = module ? ::dlsym(module, name) : nullptr;
  if (!function) throwLoadError(contents);
  return function;
}

}  // namespace map_fusion
