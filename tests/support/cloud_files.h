// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <lzf.h>
#include <octomap/octomap_types.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>
#include <vector>

/** \file
 * Writes point clouds, without the code under test. */

namespace map_tests {

using Points = std::vector<octomap::point3d>;

template <class T>
std::string bytesOf(T value, bool is_swapped = false) {
  std::string bytes(reinterpret_cast<const char*>(&value), sizeof(value));
  if (is_swapped) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

template <class... Values>
std::string textOf(Values... values) {
  std::ostringstream text;
  text.precision(9);
  ((text << values << " "), ...);
  return text.str();
}

/** Returns the header of a `.pcd` file whose points have an intensity (2 bytes) and a normal (2
 * floats) beside the coordinates. */
inline std::string pcdHeader(size_t points, const std::string& storage,
                             const std::string& viewpoint = "0 0 0 1 0 0 0") {
  const std::string n = std::to_string(points);
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x intensity y z normal\n"
         "SIZE 4 2 8 4 4\nTYPE F U F F F\nCOUNT 1 1 1 1 2\nWIDTH " +
         n + "\nHEIGHT 1\nVIEWPOINT " + viewpoint + "\nPOINTS " + n + "\nDATA " + storage + "\n";
}

/** Returns a `.pcd` file. \param[in] storage ascii, binary or binary_compressed. */
inline std::string pcdFile(const Points& points, const std::string& storage,
                           const std::string& viewpoint = "0 0 0 1 0 0 0") {
  std::string data;
  if (storage == "ascii") {
    for (const auto& p : points) data += textOf(p.x(), 7, p.y(), p.z(), 0.5, -1) + "\n";
  } else if (storage == "binary") {
    for (const auto& p : points)
      data += bytesOf(p.x()) + bytesOf<uint16_t>(7) + bytesOf<double>(p.y()) + bytesOf(p.z()) +
              bytesOf(0.5F) + bytesOf(-1.0F);
  } else {
    std::string plain;
    for (const auto& p : points) plain += bytesOf(p.x());
    for (size_t i = 0; i < points.size(); i++) plain += bytesOf<uint16_t>(7);
    for (const auto& p : points) plain += bytesOf<double>(p.y());
    for (const auto& p : points) plain += bytesOf(p.z());
    for (size_t i = 0; i < points.size(); i++) plain += bytesOf(0.5F) + bytesOf(-1.0F);
    std::string packed(2 * plain.size() + 100, '\0');
    const unsigned size = lzf_compress(plain.data(), static_cast<unsigned>(plain.size()),
                                       packed.data(), static_cast<unsigned>(packed.size()));
    packed.resize(size);
    data = bytesOf<uint32_t>(size) + bytesOf(static_cast<uint32_t>(plain.size())) + packed;
  }
  return pcdHeader(points.size(), storage, viewpoint) + data;
}

/** Returns a `.ply` file of a mesh with a camera before the vertices, whose list must be skipped.
 * \param[in] format ascii, binary_little_endian or binary_big_endian. */
inline std::string plyFile(const Points& points, const std::string& format) {
  std::string file = "ply\nformat " + format +
                     " 1.0\ncomment made by a test\nelement camera 1\nproperty list uchar short k\n"
                     "element vertex " +
                     std::to_string(points.size()) +
                     "\nproperty uchar red\nproperty float x\nproperty double y\n"
                     "property list int uchar tags\nproperty float32 z\n"
                     "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  if (format == "ascii") {
    file += "3 1 -2 3\n";
    for (const auto& p : points) file += textOf(255, p.x(), p.y(), 2, 8, 9, p.z()) + "\n";
    return file + "3 0 1 2\n";
  }
  const bool is_swapped = format == "binary_big_endian";
  file += bytesOf<uint8_t>(3);
  for (const int k : {1, -2, 3}) file += bytesOf(static_cast<int16_t>(k), is_swapped);
  for (const auto& p : points)
    file += bytesOf<uint8_t>(255) + bytesOf(p.x(), is_swapped) +
            bytesOf<double>(p.y(), is_swapped) + bytesOf<int32_t>(2, is_swapped) + "\x08\x09" +
            bytesOf(p.z(), is_swapped);
  file += bytesOf<uint8_t>(3);
  for (const int i : {0, 1, 2}) file += bytesOf(i, is_swapped);
  return file;
}

/** A cloud in a format. */
struct CloudFile {
  std::string name, bytes;
};

/** Returns the files of a cloud in all formats. */
inline std::vector<CloudFile> cloudFiles(const Points& points) {
  std::vector<CloudFile> files;
  for (const std::string storage : {"ascii", "binary", "binary_compressed"})
    files.push_back({storage + ".pcd", pcdFile(points, storage)});
  for (const std::string format : {"ascii", "binary_little_endian", "binary_big_endian"})
    files.push_back({format + ".ply", plyFile(points, format)});
  return files;
}

}  // namespace map_tests
