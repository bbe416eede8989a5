// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads the MRPT objects of a file one by one. */

#include "mrpt_fusion_maps/recordings/object_reader.h"

#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>

#include <stdexcept>

#include "fusion_base/error_text.h"
#include "fusion_base/files.h"

using mrpt::maps::CSimpleMap;
using mrpt::obs::CActionCollection;
using mrpt::obs::CObservation;
using mrpt::obs::CSensoryFrame;
using mrpt::serialization::CSerializable;

namespace mrpt::fusion {

CSerializable::Ptr ObjectReader::next() {
  auto archive = mrpt::serialization::archiveFrom(file_);
  const uint64_t start = file_.getPosition();
  try {
    auto object = archive.ReadObject();
    if (!object) throw std::runtime_error("an empty object");
    count_++;
    return object;
  } catch (const std::exception& e) {
    const bool at_end =
        dynamic_cast<const mrpt::serialization::CExceptionEOF*>(&e) && file_.getPosition() == start;
    if (at_end && count_ > 0) return nullptr;
    if (count_ == 0)
      throw std::runtime_error("not a map, simplemap or rawlog file, or truncated (" +
                               messageOf(e) + ")");
    throw std::runtime_error("truncated or corrupt after " + std::to_string(count_) + " objects (" +
                             messageOf(e) + ")");
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
