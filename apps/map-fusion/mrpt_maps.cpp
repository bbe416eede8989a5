// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Loads the module with MRPT's map classes. */

#include "mrpt_maps.h"

#include <dlfcn.h>

#include <atomic>
#include <stdexcept>
#include <string>

namespace map_fusion {

namespace {
std::atomic<const MrptMaps*> loaded_maps{nullptr};
}

const MrptMaps* loadedMrptMaps() noexcept { return loaded_maps.load(); }

const MrptMaps& mrptMaps() {
  static const MrptMaps& maps = []() -> const MrptMaps& {
    void* module =
        ::dlopen(MRPT_MAPS_MODULE, RTLD_LAZY);  // searched in the run path of this program
    void* entry = module ? ::dlsym(module, "mrptMapsOfModule") : nullptr;
    if (!entry) throw std::runtime_error(std::string("MRPT's maps: ") + ::dlerror());
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
