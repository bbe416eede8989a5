// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Loads the module with MRPT's map classes. */

#include "mrpt_maps.h"

#include <sys/mman.h>

#include <atomic>
#include <new>
#include <stdexcept>

#include "fusion_base/module.h"

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

}  // namespace

const MrptMaps* loadedMrptMaps() noexcept { return loaded_maps.load(); }

const MrptMaps& mrptMaps() {
  static const MrptMaps& maps = []() -> const MrptMaps& {
    requireAddresses(kModuleAddresses);
    void* entry =
        mrpt::fusion::functionOfModule(MRPT_MAPS_MODULE, "mrptMapsOfModule", "MRPT's maps");
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
