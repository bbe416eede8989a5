// SPDX-License-Identifier: BSD-3-Clause
#include "world.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mrpt::fusion::sim {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/** Smaller root [m] of a t^2 + 2 b t + c = 0, where a ray enters a round shape, if ahead. */
double entry(double a, double b, double c) {
  const double discriminant = b * b - a * c;
  if (a == 0 || discriminant < 0) return kNever;
  const double range = (-b - std::sqrt(discriminant)) / a;
  return range >= 0 ? range : kNever;
}

double entryOfSphere(const Eigen::Vector3d& centre, double radius, const Eigen::Vector3d& origin,
                     const Eigen::Vector3d& direction) {
  const Eigen::Vector3d o = origin - centre;
  return entry(1, o.dot(direction), o.squaredNorm() - radius * radius);
}

double lengthOf(const std::vector<Eigen::Vector2d>& way) {
  double length = 0;
  for (size_t i = 0; i + 1 < way.size(); ++i) length += (way[i + 1] - way[i]).norm();
  return length;
}

/** The point of a path that is `distance` [m] from its start, or its end. */
Eigen::Vector2d pointAlong(const std::vector<Eigen::Vector2d>& way, double distance) {
  for (size_t i = 0; i + 1 < way.size(); ++i) {
    const double leg = (way[i + 1] - way[i]).norm();
    if (distance < leg) return way[i] + (way[i + 1] - way[i]) * (distance / leg);
    distance -= leg;
  }
  return way.back();
}

}  // namespace

std::optional<double> castRay(const Capsule& capsule, const Eigen::Vector3d& origin,
                              const Eigen::Vector3d& direction) {
  const double radius = capsule.radius;
  Eigen::Vector3d low = capsule.foot, high = capsule.foot;  // ends of the axis
  low.z() += radius;
  high.z() += capsule.height - radius;

  const Eigen::Vector3d nearest(low.x(), low.y(), std::clamp(origin.z(), low.z(), high.z()));
  if ((origin - nearest).norm() <= radius) return 0.0;

  const Eigen::Vector2d o = (origin - low).head<2>(), d = direction.head<2>();
  double side = entry(d.squaredNorm(), o.dot(d), o.squaredNorm() - radius * radius);
  const double z = origin.z() + side * direction.z();
  if (!(z >= low.z() && z <= high.z())) side = kNever;
  const double range = std::min({side, entryOfSphere(low, radius, origin, direction),
                                 entryOfSphere(high, radius, origin, direction)});
  if (range == kNever) return std::nullopt;
  return range;
}

Capsule Person::at(double time) const {
  const double length = lengthOf(way);
  const double walked = std::fmod(headStart + speed * time, 2 * length);
  const Eigen::Vector2d p = pointAlong(way, std::min(walked, 2 * length - walked));
  return {{p.x(), p.y(), floorZ}, height, radius};
}

std::vector<Capsule> peopleAt(const World& world, double time) {
  std::vector<Capsule> capsules;
  for (const Person& person : world.people) capsules.push_back(person.at(time));
  return capsules;
}

std::optional<double> castRay(const World& world, const std::vector<Capsule>& people,
                              const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                              double maxRange, bool glassReturns) {
  auto range = world.solid.castRay(origin, direction, maxRange);
  const auto hide = [&](const std::optional<double>& other) {
    if (other && *other <= range.value_or(maxRange)) range = other;
  };
  if (world.glass && glassReturns)
    hide(world.glass->castRay(origin, direction, range.value_or(maxRange)));
  for (const Capsule& person : people) hide(castRay(person, origin, direction));
  return range;
}

}  // namespace mrpt::fusion::sim
