// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Guards the stack when MRPT reads sets of maps. */

#include "mrpt_fusion_maps/archives/guarded_sets.h"

#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/rtti/CObject.h>
#include <pthread.h>

#include <algorithm>
#include <cstddef>
#include <functional>

#include "fusion_base/bits.h"
#include "mrpt_fusion_maps/archives/guarded_archive.h"

using mrpt::maps::CMultiMetricMap;
using mrpt::rtti::CObject;

namespace mrpt::fusion {
namespace {

/** Part of the stack of this thread down into which objects must not nest. */
struct Forbidden {
  const char *begin = nullptr, *end = nullptr;

  /** False on a stack of another kind, as of a fiber: its bounds are not known. */
  bool holds(const char* place) const { return place >= begin && place < end; }
};

/** Returns the forbidden part of the stack of this thread; nothing if the stack is not known. */
Forbidden forbiddenPart() {
  // Most bytes to use. A stack usually has 8 MB. The destructors of nested sets need more than
  // their reading.
  constexpr size_t kMost = size_t{1} << 20U;
  pthread_attr_t attributes;
  void* low = nullptr;
  size_t size = 0;
  if (::pthread_getattr_np(::pthread_self(), &attributes) != 0) return {};
  ::pthread_attr_getstack(&attributes, &low, &size);
  ::pthread_attr_destroy(&attributes);
  const char* const begin = static_cast<const char*>(low);
  return {begin, begin + size - std::min(kMost, size / 2)};
}

CObject::Ptr createSet() {
  thread_local const Forbidden forbidden = forbiddenPart();
  if (forbidden.holds(stackPosition()))
    throw ReadingStopped("too many sets of maps within each other");
  return CMultiMetricMap::CreateObject();
}

}  // namespace

void guardSetsOfMaps() {
  // A second class of this name is no way: MRPT compares the class of an object with the class of
  // its name. A std::function is initialised at run time, so it is in writable memory.
  const auto& factory = CLASS_ID(CMultiMetricMap)->ptrCreateObject;
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast)
  const_cast<std::function<CObject::Ptr()>&>(factory) = createSet;
}

}  // namespace mrpt::fusion
