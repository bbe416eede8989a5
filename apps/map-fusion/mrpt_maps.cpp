// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Loads the module with MRPT's map classes. */

#include "mrpt_maps.h"

#include <dlfcn.h>
#include <sys/mman.h>

#include <atomic>
#include <new>
#include <stdexcept>
#include <string>

namespace map_fusion {

namespace {

std::atomic<const MrptMaps*> loaded_maps{nullptr};

/** Addresses that MRPT's libraries take while they are loaded, bytes: 215 MB on amd64, and a
 * reserve.
 */
constexpr size_t kModuleAddresses = size_t{256} << 20U;

/** Throws std::bad_alloc unless the addresses are free. Some libraries that MRPT loads do not check
 * for the end of the memory in their initialization, and a process would crash there. */
void requireAddresses(size_t bytes) {
  void* addresses =
      ::mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (addresses == MAP_FAILED) throw std::bad_alloc();
  ::munmap(addresses, bytes);
}

/** Throws the reason why the module cannot be loaded. */
[[noreturn]] void throwLoadError() {
  const char* error = ::dlerror();
  const std::string reason = error ? error : "cannot be loaded";
  // The loader of the system has words, no error codes. "TLS" is a limit of the loader itself.
  const auto says = [&](const char* words) { return reason.find(words) != std::string::npos; };
  if ((says("failed to map segment") || says("cannot map") || says("annot allocate") ||
       says("cannot create")) &&
      !says("static TLS"))
    throw std::bad_alloc();
  throw std::runtime_error("MRPT's maps: " + reason);
}

}  // namespace

const MrptMaps* loadedMrptMaps() noexcept { return loaded_maps.load(); }

const MrptMaps& mrptMaps() {
  static const MrptMaps& maps = []() -> const MrptMaps& {
    requireAddresses(kModuleAddresses);
    void* module =
        ::dlopen(MRPT_MAPS_MODULE, RTLD_LAZY);  // searched in the run path of this program
    void* entry = module ? ::dlsym(module, "mrptMapsOfModule") : nullptr;
    if (!entry) throwLoadError();
    const MrptMaps* loaded = reinterpret_cast<const MrptMaps* (*)()>(entry)();
    loaded_maps.store(loaded);
    return *loaded;
  }();
  return maps;
}

const octomap::OcTree& LoadedMap::wholeMap() const {
  if (edges) throw std::runtime_error("a map is edges alone, and a whole map is needed");
  return *octree;
}

}  // namespace map_fusion
