// SPDX-License-Identifier: BSD-3-Clause
#include "mrpt_maps.h"

#include <dlfcn.h>

#include <stdexcept>

const MrptMaps& mrptMaps() {
  static const MrptMaps& maps = []() -> const MrptMaps& {
    void* module = ::dlopen(MRPT_MAPS_MODULE, RTLD_LAZY);  // looked for where our libraries are
    void* entry = module ? ::dlsym(module, "mrptMapsOfModule") : nullptr;
    if (!entry) throw std::runtime_error(std::string("MRPT's maps: ") + ::dlerror());
    return *reinterpret_cast<const MrptMaps* (*)()>(entry)();
  }();
  return maps;
}
