// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Recognizes files that are no maps by their first bytes. */
#include "fusion_base/file_kind.h"

#include <algorithm>
#include <cctype>

namespace mrpt::fusion {
namespace {

using namespace std::string_view_literals;

/** A kind of files. */
struct Kind {
  std::string_view magic;   ///< First bytes, in lower case if the kind is text
  std::string_view advice;  ///< What the file is, and what to do
  bool is_text = false;     ///< True if upper and lower case and leading spaces do not matter
};

constexpr std::string_view kPointCloud =
    "is a point cloud of a kind that is not read: convert it to .pcd or .ply";
constexpr std::string_view kPicture =
    "is a picture, not a map: give the .ot or .bt file of the map";
constexpr std::string_view kArchive = "is an archive: unpack it and give the map that is in it";
constexpr std::string_view kWebPage =
    "is a web page, not a map: the download has probably failed, fetch the file itself";
constexpr std::string_view kGridMap =
    "is a 2-D grid map or picture (.pgm, .ppm): this program needs 3-D maps (.ot, .bt)";
constexpr std::string_view kBag =
    "is a ROS recording: save its octomap_msgs/Octomap as .ot or .bt (octomap_saver), or convert "
    "the recording to .rawlog";

constexpr Kind kKinds[] = {
    {"version https://git-lfs"sv,
     "is a git-LFS pointer, not the file itself: fetch the file with 'git lfs pull'"sv, true},
    {"<!doctype html"sv, kWebPage, true},
    {"<html"sv, kWebPage, true},
    {"<?xml"sv, "is an XML file, not a map"sv, true},
    {"LASF"sv, kPointCloud},
    {"ASTM-E57"sv, kPointCloud},
    {"# Octomap PointCloud"sv, kPointCloud},
    {"#ROSBAG"sv, kBag},
    {"\x89MCAP"sv, kBag},
    {"SQLite format 3"sv, kBag},
    {"P2"sv, kGridMap},
    {"P5"sv, kGridMap},
    {"P6"sv, kGridMap},
    {"image:"sv, "describes a 2-D grid map (.yaml): this program needs 3-D maps (.ot, .bt)"sv,
     true},
    {"\x89PNG"sv, kPicture},
    {"\xff\xd8\xff"sv, kPicture},
    {"GIF8"sv, kPicture},
    {"BM"sv, kPicture},
    {"II*\0"sv, kPicture},
    {"MM\0*"sv, kPicture},
    {"PK\x03\x04"sv, kArchive},
    {"7z\xbc\xaf"sv, kArchive},
    {"Rar!"sv, kArchive},
    {"BZh"sv, "is compressed with bzip2: unpack it (bunzip2)"sv},
    {"\xfd"
     "7zXZ"sv,
     "is compressed with xz: unpack it (unxz)"sv},
    {"\x28\xb5\x2f\xfd"sv, "is compressed with zstd: unpack it (unzstd)"sv},
    {"%PDF"sv, "is a PDF document, not a map"sv},
    {"\x7f"
     "ELF"sv,
     "is a program or a library, not a map"sv},
    {"\x93NUMPY"sv, "is an array of numpy, not a map"sv},
    {"# vtk"sv, "is a file of VTK, not a map: make an octree (.ot, .bt) of it"sv, true},
    {"#binvox"sv, "is a voxel file of binvox: convert it with binvox2bt of OctoMap"sv},
    {"scan\n"sv, "is a scan graph of OctoMap: make an octree of it with graph2tree"sv},
    {"\x1f\x8b"sv, "holds damaged gzip data, or gzip data in gzip data: unpack it (gunzip)"sv},
};

bool matches(std::string_view beginning, const Kind& kind) {
  if (!kind.is_text) return beginning.substr(0, kind.magic.size()) == kind.magic;
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (beginning.substr(0, kByteOrderMark.size()) == kByteOrderMark)
    beginning.remove_prefix(kByteOrderMark.size());
  const size_t first = beginning.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return false;
  beginning = beginning.substr(first, kind.magic.size());
  return std::equal(
      beginning.begin(), beginning.end(), kind.magic.begin(), kind.magic.end(),
      [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
}

/** Returns whether a file begins with plain text of more than a few letters. */
bool isText(std::string_view beginning) {
  constexpr size_t kFewLetters = 4;
  return beginning.size() > kFewLetters &&
         std::all_of(beginning.begin(), beginning.end(), [](char c) {
           const auto byte = static_cast<unsigned char>(c);
           return std::isprint(byte) || std::isspace(byte);
         });
}

}  // namespace

std::string foreignKindOf(std::string_view beginning) {
  for (const Kind& kind : kKinds)
    if (matches(beginning, kind)) return std::string(kind.advice);
  if (isText(beginning))
    return "is a text file, not a map: maps are .ot, .bt, .pcd, .ply, files of MRPT, .rawlog or "
           ".simplemap";
  return {};
}

bool beginsWithObject(std::string_view beginning, std::string_view wanted) {
  using namespace std::string_view_literals;
  // The length of the name of the class, then the name. In MRPT's present format the length is one
  // byte with the highest bit set; in its first format it was a number of 4 bytes.
  if (beginning.empty()) return false;
  const bool is_old = beginning.substr(1, 3) == "\0\0\0"sv;
  const size_t length = static_cast<unsigned char>(beginning[0]) & 0x7FU, start = is_old ? 4 : 1;
  constexpr size_t kShortest = 4;
  const std::string_view name = beginning.substr(start, length);
  const std::string_view own_name = name.substr(name.rfind(':') + 1);  // npos + 1 is 0
  if (!wanted.empty() && own_name != wanted) return false;
  return length >= kShortest && name.size() + start == std::min(beginning.size(), length + start) &&
         !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char c) {
           return std::isalnum(c) || c == '_' || c == ':' || c == '<' || c == '>' || c == ',';
         });
}

}  // namespace mrpt::fusion
