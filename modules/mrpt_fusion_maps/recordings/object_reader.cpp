// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads the MRPT objects of a file one by one. */

#include "mrpt_fusion_maps/recordings/object_reader.h"

#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>

#include <new>
#include <stdexcept>

#include "fusion_base/error_text.h"
#include "fusion_base/files.h"
#include "mrpt_fusion_maps/archives/map_reader.h"

using mrpt::maps::CSimpleMap;
using mrpt::obs::CActionCollection;
using mrpt::obs::CObservation;
using mrpt::obs::CSensoryFrame;
using mrpt::serialization::CSerializable;

namespace mrpt::fusion {

namespace {

constexpr const char* kNoObject = "its bytes do not begin an object of MRPT";

/** Reads the class of an object. MRPT's errors are about its own formats and advise on them. */
ObjectHeader readHeader(GuardedArchive& in) {
  try {
    return in.readHeader();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const mrpt::serialization::CExceptionEOF&) {
    throw;
  } catch (const std::exception&) {
    throw std::runtime_error(kNoObject);
  }
}

/** Returns whether a text may be the name of a class. If not, it is bytes of another format. */
bool isClassName(const std::string& text) {
  constexpr const char* kCharacters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_:<>, ";
  return !text.empty() && text.find_first_not_of(kCharacters) == std::string::npos;
}

/** Reads an object of any class. \exception std::exception If it is null or damaged. */
CSerializable::Ptr readObject(GuardedArchive& in) {
  const ObjectHeader header = readHeader(in);
  if (!isClassName(header.class_name)) throw std::runtime_error(kNoObject);
  if (isMap(header)) return readMap(in, header);
  const auto* id = mrpt::rtti::findRegisteredClass(header.class_name);
  if (!id || !id->ptrCreateObject)
    throw std::runtime_error(header.class_name == "nullptr"
                                 ? "an empty object"
                                 : "the class '" + header.class_name + "' is unknown");
  auto object = std::dynamic_pointer_cast<CSerializable>(id->createObject());
  if (!object) throw std::runtime_error("a " + header.class_name + " is not serialized");
  in.readBody(object.get(), header);
  return object;
}

}  // namespace

CSerializable::Ptr ObjectReader::next() {
  GuardedArchive archive(file_, budget_);
  const uint64_t start = file_.getPosition();
  const auto fail = [this](const std::string& reason) -> CSerializable::Ptr {
    throw std::runtime_error(
        (count_ == 0 ? "not a map, simplemap or rawlog file, or truncated ("
                     : "truncated or corrupt after " + std::to_string(count_) + " objects (") +
        reason + ")");
  };
  try {
    auto object = readObject(archive);
    count_++;
    return object;
  } catch (const ReadingStopped& e) {
    return fail(e.what());
  } catch (const mrpt::serialization::CExceptionEOF& e) {
    if (file_.getPosition() == start && count_ > 0) return nullptr;
    return fail(messageOf(e));
  } catch (const std::exception& e) {
    return fail(messageOf(e));
  }
}

CSerializable::Ptr firstObject(const std::string& path) {
  beginningOf(path);  // throws with the reason if the file cannot be read
  return ObjectReader(path).next();
}

bool isRecording(const CSerializable& first) {
  return dynamic_cast<const CSimpleMap*>(&first) || dynamic_cast<const CObservation*>(&first) ||
         dynamic_cast<const CActionCollection*>(&first) ||
         dynamic_cast<const CSensoryFrame*>(&first);
}

}  // namespace mrpt::fusion
