// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/serialization/CSerializable.h>

#include <cstddef>
#include <string>

#include "mrpt_fusion_maps/recordings/gz_stream.h"

/** \file
 * The MRPT objects of a file. */

namespace mrpt::fusion {

/** Reads the MRPT objects of a file one by one. */
class ObjectReader {
 public:
  explicit ObjectReader(const std::string& path) : file_(path) {}

  /** The next object; null at the end of the file. */
  mrpt::serialization::CSerializable::Ptr next();

 private:
  GzStream file_;
  size_t count_ = 0;
};

/** The first object of a file that is not an octree's. \exception If it cannot be read at all. */
mrpt::serialization::CSerializable::Ptr firstObject(const std::string& path);

/** Whether a file that begins with this object is a recording. */
bool isRecording(const mrpt::serialization::CSerializable& first);

}  // namespace mrpt::fusion
