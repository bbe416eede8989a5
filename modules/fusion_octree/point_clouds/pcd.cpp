// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads `.pcd` files of PCL. */

#include <lzf.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <string>
#include <vector>

#include "fusion_base/byte_reader.h"
#include "fusion_octree/point_clouds/formats.h"
#include "fusion_octree/point_clouds/scalar.h"
#include "fusion_octree/point_clouds/text_reader.h"

namespace mrpt::fusion {
namespace {

using Words = std::vector<std::string_view>;

constexpr size_t kMostFields = 1000;         // of a header
constexpr size_t kMostPerField = 1U << 20U;  // numbers of a field, for example of a histogram

/** A field of all points. */
struct Field {
  std::string_view name;
  size_t size = 0;   ///< Size of a number, bytes
  char type = 'F';   ///< F: floating point, I: integer, U: unsigned integer
  size_t count = 1;  ///< Numbers per point

  size_t bytes() const { return size * count; }
  Scalar scalar() const {
    if (type == 'F' && size == 4) return Scalar::Float32;
    if (type == 'F' && size == 8) return Scalar::Float64;
    const size_t offset = type == 'U' ? 1 : 0;
    for (const Scalar s : {Scalar::Int8, Scalar::Int16, Scalar::Int32, Scalar::Int64})
      if (type != 'F' && size == sizeOf(s))
        return static_cast<Scalar>(static_cast<size_t>(s) + offset);
    corrupt("the header has a field with a TYPE and a SIZE that do not fit");
  }
};

/** The header of a file. */
struct PcdHeader {
  std::vector<Field> fields;
  size_t points = 0;
  std::optional<octomap::point3d> viewpoint;
  std::string_view storage;  ///< "ascii", "binary" or "binary_compressed"
  std::string_view data;     ///< The bytes after the header

  size_t bytesPerPoint() const {
    size_t bytes = 0;
    for (const Field& f : fields) bytes += f.bytes();
    return bytes;
  }
  size_t numbersPerPoint() const {
    size_t numbers = 0;
    for (const Field& f : fields) numbers += f.count;
    return numbers;
  }
};

/** Where a coordinate of all points is in memory. */
struct Column {
  const char* first = nullptr;
  size_t step = 0;  ///< Distance of two points, bytes
  Scalar type = Scalar::Float32;

  double at(size_t i) const { return valueAt(first + i * step, type); }
};

std::optional<octomap::point3d> viewpointOf(const Words& words) {
  constexpr size_t kNumbers = 7;  // position, quaternion
  if (words.size() != kNumbers + 1) corrupt("VIEWPOINT has not 7 numbers");
  std::array<double, kNumbers> v{};
  for (size_t i = 0; i < kNumbers; i++) v[i] = numberOf(words[i + 1]);
  constexpr std::array<double, kNumbers> kNotStated = {0, 0, 0, 1, 0, 0, 0};
  if (v == kNotStated) return std::nullopt;
  PointCloud position;
  position.add(v[0], v[1], v[2]);
  if (position.points.empty()) corrupt("VIEWPOINT is not finite");
  return position.points.front();
}

/** Reads one value for each field from a line of the header. */
template <class Set>
void setFields(std::vector<Field>& fields, const Words& words, Set&& set) {
  if (words.size() != fields.size() + 1)
    corrupt(std::string(words[0]) + " has " + std::to_string(words.size() - 1) + " values for " +
            std::to_string(fields.size()) + " fields");
  for (size_t i = 0; i < fields.size(); i++) set(fields[i], words[i + 1]);
}

void parseFieldLine(const Words& words, std::vector<Field>& fields) {
  const std::string_view key = words[0];
  if (key == "FIELDS" || key == "COLUMNS") {
    if (words.size() > kMostFields) corrupt("the header has more than 1000 fields");
    fields.clear();
    for (size_t i = 1; i < words.size(); i++) fields.push_back({words[i]});
  } else if (key == "SIZE") {
    setFields(fields, words, [](Field& f, auto word) { f.size = wholeNumber(word, 8); });
  } else if (key == "TYPE") {
    setFields(fields, words, [](Field& f, auto word) {
      if (word != "F" && word != "I" && word != "U") corrupt("TYPE is not F, I or U");
      f.type = word[0];
    });
  } else if (key == "COUNT") {
    setFields(fields, words,
              [](Field& f, auto word) { f.count = wholeNumber(word, kMostPerField); });
  }
}

PcdHeader parseHeader(std::string_view bytes) {
  constexpr size_t kMostPoints = size_t{1} << 40U;  // so that products do not overflow
  constexpr size_t kMostSide = size_t{1} << 31U;
  PcdHeader h;
  size_t width = 0, height = 1;
  std::optional<size_t> points;
  TextReader in(bytes);
  while (h.storage.empty()) {
    const std::string_view line = in.takeLine();
    if (line.empty() || line[0] == '#') continue;
    const Words words = wordsOf(line);
    if (words.size() < 2) corrupt("a line of the header has no value");
    if (words[0] == "WIDTH") width = wholeNumber(words[1], kMostSide);
    if (words[0] == "HEIGHT") height = wholeNumber(words[1], kMostSide);
    if (words[0] == "POINTS") points = wholeNumber(words[1], kMostPoints);
    if (words[0] == "VIEWPOINT") h.viewpoint = viewpointOf(words);
    if (words[0] == "DATA") h.storage = words[1];
    parseFieldLine(words, h.fields);
  }
  h.points = points.value_or(width * height);
  if (width * height != h.points) corrupt("POINTS is not WIDTH times HEIGHT");
  for (const Field& f : h.fields) f.scalar();  // throws if it has none
  h.data = in.rest();
  return h;
}

/** Returns the numbers of the fields x, y and z. */
std::array<size_t, 3> axesOf(const std::vector<Field>& fields) {
  std::array<size_t, 3> axes{};
  constexpr std::string_view kNames[] = {"x", "y", "z"};
  for (unsigned axis = 0; axis < 3; axis++) {
    const auto field = std::find_if(fields.begin(), fields.end(),
                                    [&](const Field& f) { return f.name == kNames[axis]; });
    if (field == fields.end() || field->count != 1) corrupt("there are no coordinates x, y and z");
    axes[axis] = static_cast<size_t>(field - fields.begin());
  }
  return axes;
}

/** \exception std::runtime_error If the header announces more points than the data can hold.
 * \param[in] bytes Least number of bytes per point. */
void checkPoints(const PcdHeader& h, size_t bytes, size_t available) {
  if (h.points > available / bytes)
    corrupt("the header announces " + std::to_string(h.points) +
            " points, and the data is too short for them");
}

void readText(const PcdHeader& h, PointCloud& cloud) {
  const auto axes = axesOf(h.fields);
  checkPoints(h, 2 * h.numbersPerPoint() - 1, h.data.size());
  cloud.points.reserve(h.points);
  TextReader in(h.data);
  for (size_t i = 0; i < h.points; i++) {
    std::array<double, 3> point{};
    for (size_t field = 0; field < h.fields.size(); field++) {
      const auto axis = std::find(axes.begin(), axes.end(), field);
      if (axis != axes.end())
        point[static_cast<size_t>(axis - axes.begin())] = in.takeNumber();
      else
        for (size_t k = 0; k < h.fields[field].count; k++) in.takeWord();
    }
    cloud.add(point[0], point[1], point[2]);
  }
  if (!in.nextWord().empty())
    corrupt("there is more data than the " + std::to_string(h.points) + " points of the header");
}

void readColumns(const std::array<Column, 3>& columns, size_t points, PointCloud& cloud) {
  cloud.points.reserve(points);
  for (size_t i = 0; i < points; i++)
    cloud.add(columns[0].at(i), columns[1].at(i), columns[2].at(i));
}

/** Reads points whose numbers are side by side. Bytes behind the points are ignored: PCL pads some
 * files. */
void readBinary(const PcdHeader& h, PointCloud& cloud) {
  const auto axes = axesOf(h.fields);
  const size_t stride = h.bytesPerPoint();
  checkPoints(h, stride, h.data.size());
  std::array<Column, 3> columns;
  for (unsigned axis = 0; axis < 3; axis++) {
    size_t offset = 0;
    for (size_t f = 0; f < axes[axis]; f++) offset += h.fields[f].bytes();
    columns[axis] = {h.data.data() + offset, stride, h.fields[axes[axis]].scalar()};
  }
  readColumns(columns, h.points, cloud);
}

/** Unpacks the data of a file. The numbers of each field are side by side then. */
std::string unpacked(const PcdHeader& h) {
  // LZF packs at most 264 bytes in 3.
  constexpr size_t kMostProportion = 88;
  ByteReader in(h.data);
  const size_t packed = in.take<uint32_t>();
  const size_t plain = in.take<uint32_t>();
  const std::string_view bytes = in.takeBytes(packed);
  if (h.points > plain / h.bytesPerPoint() || plain != h.points * h.bytesPerPoint())
    corrupt("the size of the packed data is not that of " + std::to_string(h.points) + " points");
  if (plain > kMostProportion * packed) corrupt("the packed data is damaged");
  std::string data(plain, '\0');
  if (plain > 0 && lzf_decompress(bytes.data(), static_cast<unsigned>(packed), data.data(),
                                  static_cast<unsigned>(plain)) != plain)
    corrupt("the packed data is damaged");
  return data;
}

void readPacked(const PcdHeader& h, PointCloud& cloud) {
  const auto axes = axesOf(h.fields);
  const std::string data = unpacked(h);
  std::array<Column, 3> columns;
  for (unsigned axis = 0; axis < 3; axis++) {
    const Field& field = h.fields[axes[axis]];
    size_t offset = 0;
    for (size_t f = 0; f < axes[axis]; f++) offset += h.fields[f].bytes() * h.points;
    columns[axis] = {data.data() + offset, field.size, field.scalar()};
  }
  readColumns(columns, h.points, cloud);
}

}  // namespace

bool isPcd(std::string_view beginning) {
  const size_t first = beginning.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return false;
  beginning.remove_prefix(first);
  for (const std::string_view magic : {"# .pcd", "version .", "version 0."})
    if (beginning.size() >= magic.size() &&
        std::equal(magic.begin(), magic.end(), beginning.begin(),
                   [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); }))
      return true;
  return false;
}

PointCloud parsePcd(std::string_view bytes) {
  const PcdHeader h = parseHeader(bytes);
  PointCloud cloud;
  cloud.viewpoint = h.viewpoint;
  if (h.storage == "ascii")
    readText(h, cloud);
  else if (h.storage == "binary")
    readBinary(h, cloud);
  else if (h.storage == "binary_compressed")
    readPacked(h, cloud);
  else
    corrupt("DATA is not ascii, binary or binary_compressed");
  return cloud;
}

}  // namespace mrpt::fusion
