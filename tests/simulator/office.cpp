// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/random/RandomGenerators.h>

#include <cmath>
#include <utility>
#include <vector>

#include "buildings.h"
#include "furniture.h"

namespace mrpt::fusion::sim {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using mrpt::random::CRandomGenerator;

constexpr double kHeight = 3.0;                          // of all rooms [m]
constexpr double kWall = 0.15;                           // thickness of all walls [m]
constexpr double kDoorWidth = 0.95, kDoorHeight = 2.05;  // [m]

/** A stretch along x or y, from face to face of its walls [m]. */
struct Span {
  double low, high;

  double length() const { return high - low; }
  double middle() const { return (low + high) / 2; }
};

/** A row of rooms, all with their doors towards the same corridor. */
struct Row {
  Span depth;          // in y
  bool doorsAreAbove;  // at the high end of `depth`, else at the low end
};

struct Room {
  Span x, y;
  bool doorIsAbove;
  double doorX;  // middle of the door [m]
};

/** A storey of corridors along x and along y. Rooms fill the rest, two rows between two corridors
 * along x. */
struct Plan {
  double length, width;  // in x and y [m]
  std::vector<Span> corridorsAlongX, corridorsAlongY;
  uint32_t seed;  // of the rooms and the furniture
};

/** What lies between the corridors of a plan in one direction, and beside the outer ones. */
std::vector<Span> between(const std::vector<Span>& corridors, double end) {
  std::vector<Span> spans;
  double low = kWall;
  for (const Span& corridor : corridors) {
    spans.push_back({low, corridor.low - kWall});
    low = corridor.high + kWall;
  }
  spans.push_back({low, end - kWall});
  return spans;
}

/** The rows of rooms between the corridors along x, and beside the outer ones. */
std::vector<Row> rowsOf(const Plan& plan) {
  // Furniture may touch the centres of voxels: the faces are free of rounding errors.
  const auto row = [](double low, double high, bool doorsAreAbove) {
    constexpr double kPerMetre = 1 / kBuildingVoxelSize;
    return Row{{std::round(low * kPerMetre) / kPerMetre, std::round(high * kPerMetre) / kPerMetre},
               doorsAreAbove};
  };
  const std::vector<Span> blocks = between(plan.corridorsAlongX, plan.width);
  std::vector<Row> rows{row(blocks.front().low, blocks.front().high, true)};
  for (size_t i = 1; i + 1 < blocks.size(); i++) {
    const Span& block = blocks[i];
    rows.push_back(row(block.low, block.middle() - kWall / 2, false));
    rows.push_back(row(block.middle() + kWall / 2, block.high, true));
  }
  rows.push_back(row(blocks.back().low, blocks.back().high, false));
  return rows;
}

void clear(VoxelGrid& grid, const Span& x, const Span& y, double bottom, double top) {
  grid.clear({Vector3d(x.low, y.low, bottom), Vector3d(x.high, y.high, top)});
}

bool happens(double probability, CRandomGenerator& random) {
  return random.drawUniform(0.0, 1.0) < probability;
}

/** `value` [m] on the voxel grid. */
double rounded(double value) { return std::round(value / kBuildingVoxelSize) * kBuildingVoxelSize; }

/** Widths of most rooms are within 15 % of each other; now and then there is one of two. */
std::vector<Span> divide(const Span& wing, CRandomGenerator& random) {
  std::vector<Span> rooms;
  double x = wing.low;
  while (wing.high - x > 6.0) {
    double width = random.drawUniform(3.3, 4.4);
    if (happens(0.12, random)) width *= 1.8;
    const double end = rounded(x + width);
    if (wing.high - end < 2.8) break;  // what is left makes one room
    rooms.push_back({x, end});
    x = end + kWall;
  }
  rooms.push_back({x, wing.high});
  return rooms;
}

Room drawRoom(const Span& x, const Row& row, CRandomGenerator& random) {
  const double fromCorner = 0.3 + kDoorWidth / 2;
  const double offset = happens(0.5, random) ? fromCorner : x.length() - fromCorner;
  return {x, row.depth, row.doorsAreAbove, rounded(x.low + offset)};
}

std::vector<Room> drawRooms(const Plan& plan, CRandomGenerator& random) {
  const std::vector<Span> wings = between(plan.corridorsAlongY, plan.length);
  std::vector<Room> rooms;
  for (const Row& row : rowsOf(plan))
    for (const Span& wing : wings)
      for (const Span& x : divide(wing, random)) rooms.push_back(drawRoom(x, row, random));
  return rooms;
}

void carveCorridors(const Plan& plan, VoxelGrid& solid) {
  const Span inX{kWall, plan.length - kWall}, inY{kWall, plan.width - kWall};
  for (const Span& y : plan.corridorsAlongX) clear(solid, inX, y, 0, kHeight);
  for (const Span& x : plan.corridorsAlongY) clear(solid, x, inY, 0, kHeight);
}

/** The room and its doorway; few doors are shut, and leave a niche on the corridor's side. */
void carveRoom(const Room& room, CRandomGenerator& random, VoxelGrid& solid) {
  clear(solid, room.x, room.y, 0, kHeight);
  const double face = room.doorIsAbove ? room.y.high : room.y.low - kWall;
  const Span doorX{room.doorX - kDoorWidth / 2, room.doorX + kDoorWidth / 2};
  Span through{face, face + kWall};
  if (happens(0.12, random)) (room.doorIsAbove ? through.low : through.high) = face + 0.1;
  clear(solid, doorX, through, 0, kDoorHeight);
}

/** A door leaf that stands open into the room, along the nearer side wall. */
void hangDoor(const Room& room, VoxelGrid& solid) {
  const double into = room.doorIsAbove ? -1 : 1;
  const double hingeY = room.doorIsAbove ? room.y.high : room.y.low;
  const bool nearLow = room.doorX < room.x.middle();
  const double hingeX = room.doorX + (nearLow ? -1 : 1) * (kDoorWidth / 2 + 0.05);
  const double leafEnd = hingeY + into * (kDoorWidth - 0.05);
  solid.fill({Vector3d(hingeX - 0.05, std::min(hingeY, leafEnd), 0.0),
              Vector3d(hingeX + 0.05, std::max(hingeY, leafEnd), kDoorHeight)});
}

/** A spot at a wall of the room other than the one with the door; `along` tells where [0..1]. */
Spot spotAtWall(const Room& room, int wall, double along) {
  const double x = room.x.low + along * room.x.length();
  const double y = room.y.low + along * room.y.length();
  if (wall == 0) return {{room.x.low, y, 0}, -M_PI / 2};
  if (wall == 1) return {{room.x.high, y, 0}, M_PI / 2};
  if (room.doorIsAbove) return {{x, room.y.low, 0}, 0};
  return {{x, room.y.high, 0}, M_PI};
}

/** The way in, which furniture leaves free: from the door to the middle of the room [m]. */
AlignedBox3d wayIn(const Room& room) {
  AlignedBox3d way(Vector3d(room.doorX, room.y.middle(), 0));
  way.extend(Vector3d(room.x.middle(), room.y.middle(), kHeight));
  way.extend(Vector3d(room.doorX, room.doorIsAbove ? room.y.high : room.y.low, 0));
  return {way.min() - Vector3d(0.45, 0.45, 0), way.max() + Vector3d(0.45, 0.45, 0)};
}

/** Where a piece stands free of the walls and of all else, once its back has left the wall. */
bool placeInRoom(const Furniture& piece, Spot spot, const Room& room, VoxelGrid& solid) {
  const AlignedBox3d extent = extentOf(piece, spot);
  const AlignedBox3d inside(Vector3d(room.x.low - 1e-6, room.y.low - 1e-6, 0),
                            Vector3d(room.x.high + 1e-6, room.y.high + 1e-6, kHeight));
  if (!inside.contains(extent) || wayIn(room).intersects(extent)) return false;
  if (!fits(piece, spot, 0.0, solid)) return false;
  place(piece, spot, solid);
  return true;
}

/** A chair before a desk, somewhat off and turned. */
void placeChair(const Spot& desk, const Room& room, CRandomGenerator& random, VoxelGrid& solid) {
  const double away = random.drawUniform(0.9, 1.3);
  const Vector3d at = desk.at + Eigen::AngleAxisd(desk.yaw, Vector3d::UnitZ()) *
                                    Vector3d(random.drawUniform(-0.2, 0.2), away, 0);
  placeInRoom(chair(), {at, desk.yaw + M_PI + random.drawUniform(-0.7, 0.7)}, room, solid);
}

/** None to two desks, shelves and cupboards each; no two rooms get the same. */
void furnish(const Room& room, CRandomGenerator& random, VoxelGrid& solid) {
  const auto drawSpot = [&] {
    const int wall = static_cast<int>(random.drawUniform(0.0, 3.0));
    return spotAtWall(room, wall, random.drawUniform(0.15, 0.85));
  };
  for (int i = 0; i < 2; ++i) {
    const Spot spot = drawSpot();
    if (happens(0.7, random) && placeInRoom(desk(1.6), spot, room, solid))
      placeChair(spot, room, random, solid);
    const double height = happens(0.5, random) ? 1.25 : 2.05;
    if (happens(0.5, random)) placeInRoom(shelf(1.2, height), drawSpot(), room, solid);
    if (happens(0.3, random)) placeInRoom(cupboard(0.9, 1.4, 0.45), drawSpot(), room, solid);
  }
  if (room.x.length() > 5.5) {  // to meet in: a table in the half away from the door
    const double x = room.x.middle() + (room.doorX < room.x.middle() ? 1.7 : -1.7);
    placeInRoom(table(2.0, 1.0), {{x, room.y.middle(), 0}, 0}, room, solid);
  }
}

/** Printers and cupboards at the walls of the corridors, few and far between. */
void furnishCorridors(const Plan& plan, CRandomGenerator& random, VoxelGrid& solid) {
  for (const Span& y : plan.corridorsAlongX)
    for (double x = 2.0; x < plan.length - 2.0; x += random.drawUniform(5.0, 9.0)) {
      const bool above = happens(0.5, random);
      const Spot spot{{x, above ? y.high : y.low, 0}, above ? M_PI : 0.0};
      const Furniture piece = cupboard(0.7, random.drawUniform(0.8, 1.9), 0.4);
      const AlignedBox3d extent = extentOf(piece, spot);
      // Only where there is a wall behind it, and so no door.
      const double behind = above ? y.high + 0.025 : y.low - 0.025;
      bool wall = true;
      for (double at = extent.min().x(); at < extent.max().x(); at += kBuildingVoxelSize)
        wall = wall && solid.isOccupied(Vector3d(at, behind, 1.0));
      if (wall) place(piece, spot, solid);
    }
}

World build(const Plan& plan) {
  const AlignedBox3d extent(Vector3d(0, 0, -0.1), Vector3d(plan.length, plan.width, kHeight + 0.1));
  World world{VoxelGrid(kBuildingVoxelSize, extent)};
  world.solid.fill(extent);  // one block, to carve all rooms out of
  carveCorridors(plan, world.solid);

  CRandomGenerator random(plan.seed);
  const std::vector<Room> rooms = drawRooms(plan, random);
  for (const Room& room : rooms) {
    carveRoom(room, random, world.solid);
    hangDoor(room, world.solid);
    furnish(room, random, world.solid);
  }
  furnishCorridors(plan, random, world.solid);
  return world;
}

/** Corridors about their middle lines. [m] */
std::vector<Span> corridors(const std::vector<double>& middles, double width) {
  std::vector<Span> spans;
  for (const double middle : middles) spans.push_back({middle - width / 2, middle + width / 2});
  return spans;
}

}  // namespace

World office() {
  return build({50.0,
                40.0,
                {{5.65, 7.65}, {19.0, 21.0}, {32.35, 34.35}},
                {{16.1, 17.9}, {33.55, 35.45}},
                50403});
}

World storey() {
  return build({121.0, 94.0, corridors({6.65, 20.0, 34.1, 47.2, 61.05, 74.3, 87.6}, 2.0),
                corridors({17.0, 34.5, 50.2, 69.0, 85.6, 104.1}, 1.8), 50404});
}

}  // namespace mrpt::fusion::sim
