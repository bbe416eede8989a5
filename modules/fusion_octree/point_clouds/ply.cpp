// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads `.ply` files. */

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "fusion_base/byte_reader.h"
#include "fusion_octree/point_clouds/formats.h"
#include "fusion_octree/point_clouds/scalar.h"
#include "fusion_octree/point_clouds/text_reader.h"

namespace mrpt::fusion {
namespace {

constexpr size_t kMostProperties = 1000;        // of a header
constexpr size_t kMostRows = size_t{1} << 40U;  // so that products do not overflow

/** A property of the rows of an element: a number, or a list of numbers after their count. */
struct Property {
  std::string_view name;
  Scalar type = Scalar::Float32;
  std::optional<Scalar> count;  ///< Type of the count of a list
};

/** A kind of rows: vertices, faces and others. */
struct Element {
  std::string_view name;
  size_t rows = 0;
  std::vector<Property> properties;
};

/** The header of a file. */
struct PlyHeader {
  std::string_view storage;  ///< "ascii", "binary_little_endian" or "binary_big_endian"
  std::vector<Element> elements;
  std::string_view data;  ///< The bytes after the header
};

Scalar scalarOf(std::string_view name) {
  struct Name {
    std::string_view old_name, name;
    Scalar type;
  };
  constexpr Name kNames[] = {
      {"char", "int8", Scalar::Int8},        {"uchar", "uint8", Scalar::UInt8},
      {"short", "int16", Scalar::Int16},     {"ushort", "uint16", Scalar::UInt16},
      {"int", "int32", Scalar::Int32},       {"uint", "uint32", Scalar::UInt32},
      {"float", "float32", Scalar::Float32}, {"double", "float64", Scalar::Float64}};
  for (const Name& n : kNames)
    if (name == n.old_name || name == n.name) return n.type;
  corrupt("a property has an unknown type");
}

Property propertyOf(const std::vector<std::string_view>& words) {
  if (words.size() == 3) return {words[2], scalarOf(words[1]), {}};
  if (words.size() == 5 && words[1] == "list")
    return {words[4], scalarOf(words[3]), scalarOf(words[2])};
  corrupt("a line 'property' is wrong");
}

PlyHeader parsePlyHeader(std::string_view bytes) {
  PlyHeader h;
  TextReader in(bytes);
  in.takeLine();  // ply
  size_t properties = 0;
  for (auto line = in.takeLine(); line != "end_header"; line = in.takeLine()) {
    const auto words = wordsOf(line);
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "format" && words.size() > 1) {
      h.storage = words[1];
    } else if (words[0] == "element" && words.size() == 3) {
      h.elements.push_back({words[1], wholeNumber(words[2], kMostRows), {}});
    } else if (words[0] == "property" && !h.elements.empty()) {
      h.elements.back().properties.push_back(propertyOf(words));
    } else {
      corrupt("the header has a line that is no part of the format");
    }
    if (++properties > kMostProperties) corrupt("the header has more than 1000 lines");
  }
  h.data = in.rest();
  return h;
}

/** The numbers of a file of text. */
class TextRows {
 public:
  explicit TextRows(std::string_view data) : in_(data) {}

  double take(Scalar) { return in_.takeNumber(); }
  void skip(Scalar, size_t count) {
    for (size_t i = 0; i < count; i++) in_.takeWord();
  }
  size_t bytesLeft() const { return in_.rest().size() + 1; }
  static size_t leastBytesOf(Scalar) { return 2; }  // a digit and a blank

 private:
  TextReader in_;
};

/** The numbers of a binary file. */
class BinaryRows {
 public:
  BinaryRows(std::string_view data, bool is_swapped) : in_(data), is_swapped_(is_swapped) {}

  double take(Scalar type) {
    return valueAt(in_.takeBytes(sizeOf(type)).data(), type, is_swapped_);
  }
  void skip(Scalar type, size_t count) {
    if (count > in_.size() / sizeOf(type)) corrupt("the data is truncated");
    in_.takeBytes(count * sizeOf(type));
  }
  size_t bytesLeft() const { return in_.size(); }
  static size_t leastBytesOf(Scalar type) { return sizeOf(type); }

 private:
  ByteReader in_;
  bool is_swapped_;
};

/** \exception std::runtime_error If the data is too short for the rows of an element. */
template <class Rows>
void checkRows(const Element& element, const Rows& rows) {
  size_t bytes = 0;
  for (const Property& p : element.properties)
    bytes += Rows::leastBytesOf(p.count.value_or(p.type));
  if (bytes > 0 && element.rows > rows.bytesLeft() / bytes)
    corrupt("the header announces " + std::to_string(element.rows) +
            " rows, and the data is too short for them");
}

template <class Rows>
void skip(const Property& property, Rows& rows) {
  if (!property.count) return rows.skip(property.type, 1);
  const double count = rows.take(*property.count);
  if (!(count >= 0) || count > static_cast<double>(rows.bytesLeft()) || count != std::floor(count))
    corrupt("a list has a wrong count");
  rows.skip(property.type, static_cast<size_t>(count));
}

template <class Rows>
void skipRows(const Element& element, Rows& rows) {
  if (element.properties.empty()) return;
  for (size_t i = 0; i < element.rows; i++)
    for (const Property& p : element.properties) skip(p, rows);
}

/** Returns the axis of each property: 0, 1, 2, or 3 for all properties that are not coordinates. */
std::vector<size_t> axesOf(const Element& vertices) {
  constexpr size_t kNone = 3;
  constexpr std::string_view kNames[] = {"x", "y", "z"};
  std::vector<size_t> axes;
  unsigned found = 0;
  for (const Property& p : vertices.properties) {
    size_t axis = 0;
    while (axis < kNone && (p.name != kNames[axis] || p.count)) axis++;
    if (axis < kNone) found |= 1U << axis;
    axes.push_back(axis);
  }
  constexpr unsigned kAll = 7;
  if (found != kAll) corrupt("the vertices have no coordinates x, y and z");
  return axes;
}

template <class Rows>
void readVertices(const Element& vertices, Rows& rows, PointCloud& cloud) {
  const auto axes = axesOf(vertices);
  cloud.points.reserve(vertices.rows);
  for (size_t i = 0; i < vertices.rows; i++) {
    std::array<double, 3> point{};
    for (size_t k = 0; k < axes.size(); k++) {
      if (axes[k] < point.size())
        point[axes[k]] = rows.take(vertices.properties[k].type);
      else
        skip(vertices.properties[k], rows);
    }
    cloud.add(point[0], point[1], point[2]);
  }
}

/** Reads the vertices. Elements behind the vertices are not read. */
template <class Rows>
PointCloud readCloud(const PlyHeader& h, Rows rows) {
  PointCloud cloud;
  for (const Element& element : h.elements)
    if (element.name == "face" && element.rows > 0) cloud.has_faces = true;
  for (const Element& element : h.elements) {
    checkRows(element, rows);
    if (element.name == "vertex") {
      readVertices(element, rows, cloud);
      return cloud;
    }
    skipRows(element, rows);
  }
  corrupt("there is no element 'vertex'");
}

}  // namespace

bool isPly(std::string_view beginning) {
  return beginning.substr(0, 4) == "ply\n" || beginning.substr(0, 4) == "ply\r";
}

PointCloud parsePly(std::string_view bytes) {
  const PlyHeader h = parsePlyHeader(bytes);
  if (h.storage == "ascii") return readCloud(h, TextRows(h.data));
  if (h.storage == "binary_little_endian") return readCloud(h, BinaryRows(h.data, false));
  if (h.storage == "binary_big_endian") return readCloud(h, BinaryRows(h.data, true));
  corrupt("the format is not ascii, binary_little_endian or binary_big_endian");
}

}  // namespace mrpt::fusion
