// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Parses and writes poses. */

#include "pose.h"

#include <mrpt/fusion/poses.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "fusion_base/error_text.h"
#include "fusion_base/file_kind.h"
#include "fusion_base/files.h"
#include "fusion_octree/files.h"

namespace map_fusion {

namespace {

constexpr size_t kMostPoseBytes = size_t{1} << 20U;  // a matrix has at most 16 numbers

/** Parses a text of \a count numbers. \exception std::runtime_error "<what>: <reason>". */
std::vector<double> parseNumbers(const std::string& text, size_t count, const std::string& what) {
  std::istringstream in(text);
  std::vector<double> numbers;
  std::string word;
  while (in >> word) {
    const auto is_text = [](char c) { return c > ' ' && c <= '~'; };
    if (!std::all_of(word.begin(), word.end(), is_text))  // never the bytes of, say, a picture
      throw std::runtime_error(what + ": there are characters that belong to no number");
    if (word.find(',') != std::string::npos)
      throw std::runtime_error(what + ": blanks separate the numbers, not commas");
    numbers.push_back(mrpt::fusion::withPath(what, [&] { return parseNumber(word); }));
  }
  if (numbers.size() != count)
    throw std::runtime_error(what + ": expected " + std::to_string(count) + " numbers");
  return numbers;
}

mrpt::poses::CPose3D parseMatrix(const std::string& text) {
  const auto v = parseNumbers(text, 16, "a 4x4 matrix");
  return mrpt::fusion::toPose(mrpt::fusion::toRigid(
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(v.data())));
}

}  // namespace

double parseNumber(const std::string& word) {
  size_t used = 0;
  double value = 0;
  try {
    value = std::stod(word, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used != word.size() || !std::isfinite(value))
    throw std::runtime_error("'" + word.substr(0, 20) + "' is not a finite number");
  return value;
}

mrpt::poses::CPose3D parsePose(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t");
  if (first != std::string::npos && text[first] == '[') {
    const size_t last = text.find_last_not_of(" \t");
    const std::string what = "pose '" + text + "'";
    if (text[last] != ']') throw std::runtime_error(what + ": does not end in ']'");
    const auto v = parseNumbers(text.substr(first + 1, last - first - 1), 6,
                                what + " is not [x y z yaw pitch roll] (m, deg)");
    return mrpt::poses::CPose3D(v[0], v[1], v[2], mrpt::DEG2RAD(v[3]), mrpt::DEG2RAD(v[4]),
                                mrpt::DEG2RAD(v[5]));
  }
  const bool is_number =
      !text.empty() && text.find_first_not_of("+-.0123456789eE, \t") == std::string::npos;
  std::error_code none;
  if (is_number && !std::filesystem::exists(text, none))
    throw std::runtime_error("pose '" + text + "': six numbers need [ ] and quotes: " +
                             "\"[x y z yaw pitch roll]\" (m, deg)");
  return mrpt::fusion::withPath(text, [&] {
    // A pipe can be read only once.
    if (std::filesystem::is_regular_file(text, none) &&
        mrpt::fusion::isOcTreeFile(mrpt::fusion::beginningOf(text)))
      throw std::runtime_error("is a map, not a pose");
    return parseMatrix(mrpt::fusion::readFileBytes(text, kMostPoseBytes));
  });
}

mrpt::math::TPoint3D parsePoint(const std::string& text) {
  std::string numbers = text;
  if (!text.empty() && text.front() == '[' && text.back() == ']')
    numbers = text.substr(1, text.size() - 2);
  const auto v = parseNumbers(numbers, 3, "point '" + text + "' is not \"x y z\" (m)");
  return {v[0], v[1], v[2]};
}

std::string toMatrixText(const mrpt::poses::CPose3D& pose) {
  std::ostringstream out;
  out.precision(12);
  out << std::fixed << mrpt::fusion::toEigen(pose).matrix() << "\n";
  return out.str();
}

}  // namespace map_fusion
