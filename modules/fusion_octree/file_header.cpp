// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Parses the headers of `.ot` and `.bt` files. */
#include "fusion_octree/file_header.h"

#include <istream>
#include <limits>
#include <sstream>

#include "fusion_base/byte_reader.h"
#include "fusion_octree/resolution.h"

namespace mrpt::fusion {
namespace {

constexpr std::string_view kLegacyMagic{"\3\0\0\0", 4};  // type of the octree, int32
constexpr size_t kLegacyHeaderBytes = 16;

bool startsWith(std::string_view s, std::string_view prefix) {
  return s.substr(0, prefix.size()) == prefix;
}

/** Parses the header of 16 bytes: type, resolution, number of nodes. */
OcTreeHeader parseLegacyHeader(std::string_view bytes) {
  ByteReader in(bytes);
  in.takeBytes(kLegacyMagic.size());
  OcTreeHeader h;
  h.format = OcTreeFormat::LegacyBt;
  h.id = "OcTree";
  h.resolution = in.take<double>();
  h.size = in.take<uint32_t>();
  h.data = bytes.substr(kLegacyHeaderBytes);
  return h;
}

void skipLine(std::istream& in) { in.ignore(std::numeric_limits<std::streamsize>::max(), '\n'); }

template <class T>
void takeValue(std::istream& in, T& value, const char* what) {
  if (!(in >> value)) corrupt(std::string("the header has no valid ") + what);
}

OcTreeHeader parseTextHeader(std::string_view bytes) {
  constexpr size_t kMostBytes = size_t{1} << 20U;
  std::istringstream in(std::string(bytes.substr(0, kMostBytes)));
  OcTreeHeader h;
  bool has_size = false;
  skipLine(in);  // the first line
  std::string word;
  while (in >> word && word != "data") {
    if (word == "id")
      takeValue(in, h.id, "'id'");
    else if (word == "size")
      takeValue(in, h.size, "'size'"), has_size = true;
    else if (word == "res")
      takeValue(in, h.resolution, "'res' (voxel size in metres)");
    else
      skipLine(in);  // a comment or an unknown keyword
  }
  if (!in && bytes.size() >= kMostBytes)
    corrupt("the header is longer than " + std::to_string(kMostBytes) + " bytes");
  skipLine(in);  // the rest of the line of 'data'
  if (!in || in.eof()) corrupt("the header ends before its 'data' line");
  if (h.id.empty()) corrupt("the header has no 'id'");
  if (!has_size) corrupt("the header has no valid 'size'");
  if (h.id == "1") h.id = "OcTree";  // before OctoMap 1.0
  h.data = bytes.substr(static_cast<size_t>(in.tellg()));
  return h;
}

}  // namespace

std::optional<OcTreeFormat> ocTreeFormatOf(std::string_view bytes) {
  if (startsWith(bytes, kOtMagic)) return OcTreeFormat::Ot;
  if (startsWith(bytes, kBtMagic)) return OcTreeFormat::Bt;
  if (startsWith(bytes, kLegacyMagic) && bytes.size() >= kLegacyHeaderBytes &&
      isResolution(parseLegacyHeader(bytes).resolution))
    return OcTreeFormat::LegacyBt;
  return std::nullopt;
}

OcTreeHeader parseOcTreeHeader(std::string_view bytes) {
  const auto format = ocTreeFormatOf(bytes);
  if (!format) corrupt("not an OctoMap file (.ot or .bt)");
  if (*format == OcTreeFormat::LegacyBt) return parseLegacyHeader(bytes);
  OcTreeHeader h = parseTextHeader(bytes);
  h.format = *format;
  checkResolution(h.resolution);
  return h;
}

}  // namespace mrpt::fusion
