// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/serialization/CSerializable.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "mrpt_fusion_maps/archives/guarded_archive.h"
#include "mrpt_fusion_maps/recordings/gz_stream.h"

/** \file
 * Reads the MRPT objects of a file. */

namespace mrpt::fusion {

/** Reads the MRPT objects of a file one by one. All objects share one ReadingBudget. */
class ObjectReader {
 public:
  explicit ObjectReader(const std::string& path) : file_(path) {}

  /** Returns the next object. Null at the end of the file. \exception std::runtime_error If the
   * file is of another kind or truncated. */
  mrpt::serialization::CSerializable::Ptr next();
  /** Returns the number of uncompressed bytes of the objects so far. */
  uint64_t bytes() const { return file_.getPosition(); }

 private:
  GzStream file_;
  ReadingBudget budget_;
  size_t count_ = 0;
};

/** Returns the first object of a file. \exception std::runtime_error If the file cannot be read. */
mrpt::serialization::CSerializable::Ptr firstObject(const std::string& path);

/** Returns whether a file that begins with this object is a recording. */
bool isRecording(const mrpt::serialization::CSerializable& first);

}  // namespace mrpt::fusion
