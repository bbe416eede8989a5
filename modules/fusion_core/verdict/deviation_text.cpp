// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Writes the standard deviations of a pose as text. */
#include "fusion_core/verdict/deviation_text.h"

#include <cmath>
#include <cstdio>

namespace mrpt::fusion {
namespace {

/** Returns a direction as text with a word for it. */
std::string textOf(const Eigen::Vector3d& direction) {
  constexpr double kSinus = 0.1;                                              // 6 deg
  const auto rounded = [](double x) { return std::abs(x) < 0.005 ? 0 : x; };  // never -0.00
  const double across = std::hypot(direction.x(), direction.y());
  const char* word = across < kSinus                    ? " (vertical)"
                     : std::abs(direction.z()) < kSinus ? " (level)"
                                                        : "";
  char text[96];
  std::snprintf(text, sizeof(text), "[%.2f %.2f %.2f]%s", rounded(direction.x()),
                rounded(direction.y()), rounded(direction.z()), word);
  return text;
}

/** Returns where a map moves freely: in the first \a free directions, or about the first axes. */
std::string freedom(const Eigen::Matrix3d& axes, unsigned free, const std::string& by_one,
                    const std::string& by_all) {
  if (free >= 3) return by_all;
  if (free == 2) return by_all + " across " + textOf(axes.col(2));
  return by_one + " " + textOf(axes.col(0));
}

/** Returns a standard deviation with its direction, if that is known. */
std::string deviationText(double value, const char* unit, const char* by,
                          const Eigen::Matrix3d& axes) {
  char text[48];
  std::snprintf(text, sizeof(text), "%.2g %s", value, unit);
  return axes.isZero(0) ? text : std::string(text) + by + textOf(axes.col(0));
}

}  // namespace

std::string textOf(const PoseDeviation& d) {
  const std::string turns =
      "turns freely " + freedom(d.axes, d.free_axes, "about", "about all axes");
  const std::string slides =
      "slides freely " + freedom(d.directions, d.free_directions, "along", "in all directions");
  if (d.free_axes > 0 && d.free_directions > 0)
    return "map B " + slides + " and " + turns + " of map A's frame";
  if (d.free_axes > 0) return "map B " + turns + " of map A's frame";
  if (d.free_directions > 0) return "map B " + slides + " of map A's frame";
  return "standard deviations " + deviationText(d.translation, "m", " along ", d.directions) +
         ", " + deviationText(d.rotation * 180 / M_PI, "deg", " about ", d.axes) +
         (d.directions.isZero(0) ? "" : " of map A's frame");
}

}  // namespace mrpt::fusion
