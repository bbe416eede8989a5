// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Guards the memory and the stack when MRPT reads collections of objects. */

#include "mrpt_fusion_maps/archives/guarded_collections.h"

#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPosePDF.h>
#include <mrpt/rtti/CObject.h>
#include <mrpt/serialization/CArchive.h>
#include <pthread.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "fusion_base/bits.h"
#include "mrpt_fusion_maps/archives/guarded_archive.h"

using mrpt::maps::CMultiMetricMap;
using mrpt::maps::CSimpleMap;
using mrpt::obs::CActionCollection;
using mrpt::obs::CSensoryFrame;
using mrpt::rtti::CObject;
using mrpt::serialization::CArchive;

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

// The classes below read what MRPT's classes read. They have the runtime class of their bases,
// because MRPT compares the class of an object with the class of its name. A version that they do
// not know is left to MRPT, which refuses it.

/** A set of maps. The memory that it uses is in proportion to the bytes that it reads. */
class GuardedSet : public CMultiMetricMap {
 protected:
  void serializeFrom(CArchive& in, uint8_t version) override {
    constexpr uint8_t kWithNumber = 11, kLatest = 12;
    if (version != kWithNumber && version != kLatest)
      return CMultiMetricMap::serializeFrom(in, version);
    maps.clear();
    if (version == kWithNumber) in.ReadAs<uint32_t>();
    for (auto left = in.ReadAs<uint32_t>(); left > 0; left--)
      maps.push_back(in.ReadObject<mrpt::maps::CMetricMap>());
  }
};

/** A simplemap, see GuardedSet. */
class GuardedSimpleMap : public CSimpleMap {
 protected:
  void serializeFrom(CArchive& in, uint8_t version) override {
    constexpr uint8_t kFlat = 0, kLatest = 1;
    if (version != kFlat && version != kLatest) return CSimpleMap::serializeFrom(in, version);
    clear();
    for (auto left = in.ReadAs<uint32_t>(); left > 0; left--) {
      if (version == kFlat) {
        const auto pose = in.ReadObject<mrpt::poses::CPosePDF>();
        if (!pose) throw ReadingStopped("a keyframe has no pose");
        insert(pose, in.ReadObject<CSensoryFrame>());
      } else {
        const auto pose = in.ReadObject<mrpt::poses::CPose3DPDF>();
        insert(pose, in.ReadObject<CSensoryFrame>());
      }
    }
  }
};

/** A frame of observations, see GuardedSet. */
class GuardedFrame : public CSensoryFrame {
 protected:
  void serializeFrom(CArchive& in, uint8_t version) override {
    constexpr uint8_t kWithTime = 0, kWithNumber = 1, kLatest = 2;
    if (version > kLatest) return CSensoryFrame::serializeFrom(in, version);
    clear();
    mrpt::Clock::time_point time;
    if (version <= kWithNumber) in.ReadAs<uint32_t>();
    if (version == kWithTime) in >> time;
    for (auto left = in.ReadAs<uint32_t>(); left > 0; left--) {
      const auto observation = in.ReadObject<mrpt::obs::CObservation>();
      if (observation && version == kWithTime) observation->timestamp = time;
      insert(observation);
    }
  }
};

/** The actions of a time step, see GuardedSet. */
class GuardedActions : public CActionCollection {
 protected:
  void serializeFrom(CArchive& in, uint8_t version) override {
    if (version != 0) return CActionCollection::serializeFrom(in, version);
    clear();
    for (auto left = in.ReadAs<uint32_t>(); left > 0; left--) {
      const auto action = in.ReadObject<mrpt::obs::CAction>();
      if (!action) throw ReadingStopped("an object among actions is no action");
      insertPtr(action);
    }
  }
};

CObject::Ptr createSet() {
  thread_local const Forbidden forbidden = forbiddenPart();
  if (forbidden.holds(stackPosition()))
    throw ReadingStopped("too many sets of maps within each other");
  return std::make_shared<GuardedSet>();
}

/** Replaces the factory of a class. A std::function is initialised at run time, so it is in
 * writable memory. */
void replaceFactory(const mrpt::rtti::TRuntimeClassId* id, CObject::Ptr (*create)()) {
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast)
  const_cast<std::function<CObject::Ptr()>&>(id->ptrCreateObject) = create;
}

template <class T>
CObject::Ptr create() {
  return std::make_shared<T>();
}

}  // namespace

void guardCollections() {
  replaceFactory(CLASS_ID(CMultiMetricMap), createSet);
  replaceFactory(CLASS_ID(CSimpleMap), create<GuardedSimpleMap>);
  replaceFactory(CLASS_ID(CSensoryFrame), create<GuardedFrame>);
  replaceFactory(CLASS_ID(CActionCollection), create<GuardedActions>);
}

}  // namespace mrpt::fusion
