// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Writes MRPT objects to a file: the whole file or nothing. */

#include "mrpt_fusion_maps/recordings/object_writer.h"

#include <mrpt/fusion/map_files.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/system/filesystem.h>

#include <string_view>

#include "fusion_base/files.h"
#include "mrpt_fusion_maps/recordings/gz_stream.h"

namespace mrpt::fusion {

void saveObjects(const std::vector<const mrpt::serialization::CSerializable*>& objects,
                 const std::string& path) {
  mrpt::io::CMemoryStream memory;
  auto archive = mrpt::serialization::archiveFrom(memory);
  for (const auto* object : objects) archive << *object;
  const std::string_view bytes(static_cast<const char*>(memory.getRawBufferData()),
                               static_cast<size_t>(memory.getTotalBytesCount()));
  const std::string extension = mrpt::system::extractFileExtension(path);
  if (extension == "gz" || extension == "3Dscene" || extension == "simplemap")
    writeFileAtomically(path, gzCompressed(bytes));
  else
    writeFileAtomically(path, bytes);
}

void saveObject(const mrpt::serialization::CSerializable& object, const std::string& path) {
  saveObjects({&object}, path);
}

}  // namespace mrpt::fusion
