// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Loads the module of the link over DDS. */
#include "fusion_link/dds_link.h"

#include <dlfcn.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace mrpt::fusion {
namespace {

#ifdef DDS_MODULE
/** Loads the module: from the run path, or from its place below the library that this code is part
 * of. */
void* loadModule() {
  if (void* module = ::dlopen(DDS_MODULE, RTLD_LAZY)) return module;
  const char* error = ::dlerror();
  const std::string reason = error ? error : "cannot be loaded";
  static const char here = 0;
  Dl_info own{};
  if (::dladdr(&here, &own) != 0 && own.dli_fname) {
    const auto folder = std::filesystem::path(own.dli_fname).parent_path();
    if (void* module = ::dlopen((folder / "mrpt-fusion" / DDS_MODULE).c_str(), RTLD_LAZY))
      return module;
  }
  throw std::runtime_error("the link: " + reason);
}
#endif

}  // namespace

std::unique_ptr<Link> openLink([[maybe_unused]] const DdsSettings& settings) {
#ifdef DDS_MODULE
  const auto open = reinterpret_cast<OpenDdsLink>(::dlsym(loadModule(), kOpenDdsLink));
  if (!open) throw std::runtime_error("the link: " DDS_MODULE " is of another version");
  return std::unique_ptr<Link>(open(settings));
#else
  throw std::runtime_error(
      "robots join by CycloneDDS (Debian package cyclonedds-dev), without which this program was "
      "built");
#endif
}

}  // namespace mrpt::fusion
