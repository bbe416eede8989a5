// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Loads modules: libraries that only some runs need. */

#include "fusion_base/module.h"

#include <dlfcn.h>

#include <filesystem>
#include <new>
#include <stdexcept>

namespace mrpt::fusion {

namespace {

std::string reasonOfLoader() {
  const char* error = ::dlerror();
  return error ? error : "cannot be loaded";
}

/** Throws the reason why the module cannot be loaded. */
[[noreturn]] void throwLoadError(const std::string& contents, const std::string& reason) {
  // The loader of the system has words, no error codes. "TLS" is a limit of the loader itself.
  const auto says = [&](const char* words) { return reason.find(words) != std::string::npos; };
  if ((says("failed to map segment") || says("cannot map") || says("annot allocate") ||
       says("cannot create")) &&
      !says("static TLS"))
    throw std::bad_alloc();
  throw std::runtime_error(contents + ": " + reason);
}

void* loadBesideThisCode(const char* file) {
  static const char here = 0;
  Dl_info own{};
  if (::dladdr(&here, &own) == 0 || !own.dli_fname) return nullptr;
  const auto folder = std::filesystem::path(own.dli_fname).parent_path();
  return ::dlopen((folder / "mrpt-fusion" / file).c_str(), RTLD_LAZY);
}

}  // namespace

void* functionOfModule(const char* file, const char* name, const std::string& contents) {
  void* module = ::dlopen(file, RTLD_LAZY);
  if (!module) {
    const std::string reason = reasonOfLoader();
    module = loadBesideThisCode(file);
    if (!module) throwLoadError(contents, reason);
  }
  void* function = ::dlsym(module, name);
  if (!function) throwLoadError(contents, reasonOfLoader());
  return function;
}

}  // namespace mrpt::fusion
