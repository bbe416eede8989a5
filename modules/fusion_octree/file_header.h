// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/** \file
 * The headers of OctoMap's files. */

namespace mrpt::fusion {

/** Formats of OctoMap's files. */
enum class OcTreeFormat {
  Ot,        ///< `.ot`
  Bt,        ///< `.bt`
  LegacyBt,  ///< `.bt` of OctoMap before 1.0 (2010): a header of 16 bytes
};

constexpr std::string_view kOtMagic = "# Octomap OcTree file";         ///< First line of `.ot`
constexpr std::string_view kBtMagic = "# Octomap OcTree binary file";  ///< First line of `.bt`

/** Returns the format of a file by its first bytes, at least 29. Nothing: another kind of file. */
std::optional<OcTreeFormat> ocTreeFormatOf(std::string_view bytes);

/** The header of an octree file. */
struct OcTreeHeader {
  OcTreeFormat format = OcTreeFormat::Ot;  ///< Format of the file
  std::string id;                          ///< Type of the octree, for example "OcTree"
  uint32_t size = 0;                       ///< Number of nodes, as announced
  double resolution = 0;                   ///< Voxel size, m
  std::string_view data;                   ///< Bytes after the header
};

/** Parses a header as OctoMap does: keywords and values are separated by any white space, an
 * unknown keyword is skipped with its line, and the old id "1" is "OcTree". \exception
 * std::runtime_error If a value is missing or wrong, if the resolution is out of
 * range, or if the header is longer than 1 MB. */
OcTreeHeader parseOcTreeHeader(std::string_view bytes);

}  // namespace mrpt::fusion
