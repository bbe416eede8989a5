// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/random/RandomGenerators.h>

#include <cmath>

#include "buildings.h"
#include "furniture.h"

namespace mrpt::fusion::sim {
namespace {

using Eigen::AlignedBox2d;
using Eigen::AlignedBox3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using mrpt::random::CRandomGenerator;

constexpr double kLength = 40.0, kWidth = 15.0, kHeight = 3.0;  // of the hall [m]
constexpr uint32_t kLayoutSeed = 40153;

/** Where people walk and no furniture stands [m]. */
const std::vector<AlignedBox2d> kAisles{
    {Vector2d(0.6, 6.3), Vector2d(39.4, 8.6)},    // the length of the hall
    {Vector2d(8.8, 1.2), Vector2d(10.2, 14.2)},   // three across it
    {Vector2d(18.8, -0.5), Vector2d(21.0, 9.8)},  // from the entrance to the reception
    {Vector2d(23.0, 1.2), Vector2d(24.4, 14.2)}, {Vector2d(31.0, 1.2), Vector2d(32.4, 9.8)},
};

void fill(VoxelGrid& grid, double x0, double y0, double z0, double x1, double y1, double z1) {
  grid.fill({Vector3d(x0, y0, z0), Vector3d(x1, y1, z1)});
}

void clear(VoxelGrid& grid, double x0, double y0, double z0, double x1, double y1, double z1) {
  grid.clear({Vector3d(x0, y0, z0), Vector3d(x1, y1, z1)});
}

/** Floor, ceiling and all outer walls but the glass front. */
void buildShell(VoxelGrid& solid) {
  fill(solid, -0.2, -0.2, -0.1, kLength + 0.2, kWidth + 0.8, 0);
  fill(solid, -0.2, -0.2, kHeight, kLength + 0.2, kWidth + 0.8, kHeight + 0.1);
  fill(solid, -0.2, -0.2, 0, 0, kWidth + 0.8, kHeight);
  fill(solid, kLength, -0.2, 0, kLength + 0.2, kWidth + 0.8, kHeight);
  fill(solid, 0, -0.2, 0, 6.0, 0, kHeight);
  fill(solid, 34.0, -0.2, 0, kLength, 0, kHeight);
  fill(solid, 0, kWidth, 0, kLength, kWidth + 0.8, kHeight);
}

/** Doors and lifts set back in the walls. */
void carveNiches(VoxelGrid& solid) {
  for (const double x : {5.35, 7.85, 11.0}) clear(solid, x, kWidth, 0, x + 1.3, kWidth + 0.35, 2.2);
  for (const double x : {16.15, 27.6, 29.4})
    clear(solid, x, kWidth, 0, x + 0.95, kWidth + 0.2, 2.1);
  clear(solid, 2.0, kWidth, 0, 4.2, kWidth + 0.65, 2.4);     // with vending machines, see below
  clear(solid, -0.1, 6.6, 0, 0, 8.4, 2.3);                   // double door in the west
  clear(solid, kLength, 7.0, 0, kLength + 0.1, 8.8, 2.3);    // and in the east
  clear(solid, kLength, 3.9, 0.9, kLength + 0.1, 6.1, 2.2);  // a show case
}

/** A sill, posts and a lintel, and panes between them; the entrance is open. */
void buildGlassFront(VoxelGrid& solid, VoxelGrid& glass) {
  const double entranceFrom = 18.9, entranceTo = 20.9;
  fill(solid, 6.0, -0.2, 0, 34.0, -0.05, 0.25);
  fill(solid, 6.0, -0.2, 2.6, 34.0, 0, kHeight);
  glass.fill({Vector3d(6.0, -0.1, 0.25), Vector3d(34.0, -0.05, 2.6)});
  for (double x = 6.0; x < 34.0; x += 1.85) fill(solid, x, -0.15, 0, x + 0.1, 0, 2.6);
  clear(solid, entranceFrom, -0.2, 0, entranceTo, 0, 2.6);
  glass.clear({Vector3d(entranceFrom, -0.2, 0), Vector3d(entranceTo, 0, 2.6)});
}

/** What is seen through the glass. */
void buildTerrace(VoxelGrid& solid) {
  fill(solid, 4.0, -3.2, -0.1, 36.0, -0.2, 0);
  fill(solid, 4.0, -3.2, 0, 17.5, -3.0, 0.9);
  fill(solid, 22.3, -3.2, 0, 36.0, -3.0, 0.9);
  for (const double x : {7.3, 12.9, 26.2, 32.7}) {
    place(bench(2.0), {{x, -2.3, 0}, 0.0}, solid);
    fill(solid, x + 1.8, -2.6, 0, x + 2.1, -2.3, kHeight);  // the trunk of a tree
  }
}

/** Pillars in two rows, square ones in the south and round ones in the north; beams above them. */
void buildPillars(VoxelGrid& solid) {
  for (int i = 0; i < 7; ++i) {
    const double x = 4.65 + 5.1 * i;
    fill(solid, x - 0.275, 4.7, 0, x + 0.275, 5.25, kHeight);
    fill(solid, x - 0.15, 0, 2.65, x + 0.15, kWidth, kHeight);
    const Vector2d axis(x, 10.3);
    solid.fillWhere({Vector3d(x - 0.35, 9.95, 0), Vector3d(x + 0.35, 10.65, kHeight)},
                    [&](const Vector3d& p) { return (p.head<2>() - axis).norm() <= 0.32; });
  }
}

/** Walls that divide parts of the hall off. */
void buildPartitions(VoxelGrid& solid) {
  fill(solid, 12.85, 11.2, 0, 13.0, kWidth, kHeight);  // two bays in the north...
  clear(solid, 12.85, 12.6, 0, 13.0, 13.6, 2.1);       // ...joined by a door
  fill(solid, 28.3, 0, 0, 28.45, 4.1, kHeight);        // a bay at the front
  fill(solid, 14.4, 2.9, 0, 17.9, 3.05, 1.3);          // a low wall along the cafe
  fill(solid, 26.1, 9.9, 0, 29.4, 10.05, 1.6);         // and along the waiting area
  fill(solid, 33.3, 10.4, 0, 33.45, kWidth, kHeight);  // the porter's office
  fill(solid, 33.3, 10.4, 0, kLength, 10.55, kHeight);
  clear(solid, 35.2, 10.4, 0, 36.2, 10.55, 2.1);
  clear(solid, 37.3, 10.4, 1.0, 39.3, 10.55, 2.0);  // its window to the hall
  fill(solid, 0, 9.75, 0, 2.4, 9.9, kHeight);       // a cloak room
  fill(solid, 2.4, 9.75, 0, 2.55, 11.6, kHeight);
}

/** Stairs along the east wall, up to a landing. */
void buildStairs(VoxelGrid& solid) {
  for (int step = 0; step < 6; ++step) {
    const double y = 3.6 - 0.3 * step;
    fill(solid, 37.2, y - 0.3, 0, kLength, y, 0.15 * (step + 1));
  }
  fill(solid, 37.2, 0, 0, kLength, 1.8, 1.05);
  fill(solid, 37.1, 0, 0, 37.2, 3.6, 1.1);  // its wall
}

/** What stands where it does on purpose. */
void furnish(CRandomGenerator& random, VoxelGrid& solid) {
  place(receptionDesk(), {{16.9, 11.4, 0}, 0.0}, solid);
  place(chair(), {{16.1, 12.5, 0}, M_PI}, solid);
  place(chair(), {{17.9, 12.4, 0}, 2.8}, solid);
  place(cupboard(3.2, 1.9, 0.4), {{19.3, kWidth, 0}, M_PI}, solid);
  for (const double x : {2.55, 3.55}) place(cupboard(0.85, 1.85, 0.6), {{x, 15.6, 0}, M_PI}, solid);
  place(desk(1.8), {{38.2, kWidth, 0}, M_PI}, solid);
  place(chair(), {{38.1, 13.7, 0}, 0.2}, solid);
  place(shelf(1.8, 2.0), {{33.45, 12.9, 0}, -M_PI / 2}, solid);
  place(shelf(1.4, 2.0), {{0, 12.3, 0}, -M_PI / 2}, solid);
  place(cupboard(2.4, 1.05, 0.6), {{30.2, 0.0, 0}, 0.0}, solid);  // the cafe's counter
  fill(solid, 0.4, 13.0, 2.45, 33.2, 13.45, 2.65);                // an air duct under the beams
  fill(solid, 22.0, 14.85, 1.2, 24.6, kWidth, 2.4);               // a screen on the wall
  for (const double x : {3.1, 13.3, 25.1, 36.0})
    place(hangingSign(), {{x, 7.45, kHeight}, M_PI / 2}, solid);
  for (const double x : {16.7, 21.9, 29.9}) place(plant(random), {{x, 9.0, 0}, 0.0}, solid);
}

/** Tables with chairs, armchairs, benches...: whatever a visitor may have moved last. */
std::vector<Furniture> looseFurniture(CRandomGenerator& random) {
  std::vector<Furniture> pieces;
  for (int i = 0; i < 5; ++i) pieces.push_back(table(1.6, 0.8));
  for (int i = 0; i < 6; ++i) pieces.push_back(table(0.8, 0.8));
  for (int i = 0; i < 8; ++i) pieces.push_back(armchair());
  for (int i = 0; i < 5; ++i) pieces.push_back(bench(2.0));
  for (int i = 0; i < 10; ++i) pieces.push_back(plant(random));
  for (int i = 0; i < 5; ++i) pieces.push_back(signStand());
  for (int i = 0; i < 6; ++i) pieces.push_back(bin());
  for (int i = 0; i < 20; ++i) pieces.push_back(chair());
  return pieces;
}

bool isInAisle(const AlignedBox3d& extent) {
  const AlignedBox2d footprint(extent.min().head<2>(), extent.max().head<2>());
  for (const AlignedBox2d& aisle : kAisles)
    if (aisle.intersects(footprint)) return true;
  return false;
}

/** Puts each piece at a drawn spot that is free; leaves it out if a few draws find none. */
void scatter(const std::vector<Furniture>& pieces, CRandomGenerator& random, VoxelGrid& solid) {
  for (const Furniture& piece : pieces)
    for (int draw = 0; draw < 50; ++draw) {
      const double x = random.drawUniform(0.4, kLength - 0.4);
      const double y = random.drawUniform(0.4, kWidth - 0.4);
      const Spot spot{{x, y, 0.0}, random.drawUniform(-M_PI, M_PI)};
      if (isInAisle(extentOf(piece, spot)) || !fits(piece, spot, 0.1, solid)) continue;
      place(piece, spot, solid);
      break;
    }
}

void hangLamps(CRandomGenerator& random, VoxelGrid& solid) {
  for (int i = 0; i < 24; ++i) {
    const double x = random.drawUniform(1.0, kLength - 1.0);
    const double y = random.drawUniform(1.0, kWidth - 1.0);
    const Spot spot{{x, y, kHeight}, random.drawUniform(-M_PI, M_PI)};
    if (fits(hangingLamp(), spot, 0.2, solid)) place(hangingLamp(), spot, solid);
  }
}

/** A path, pace, way made at time 0, and height. */
Person walker(const std::vector<Vector2d>& way, double speed, double headStart, double height) {
  Person person;
  person.way = way;
  person.speed = speed;
  person.headStart = headStart;
  person.height = height;
  return person;
}

std::vector<Person> visitors() {
  return {
      walker({{1.0, 6.65}, {39.0, 6.65}}, 1.1, 3.0, 1.78),
      walker({{39.0, 6.75}, {2.0, 6.75}}, 0.9, 12.0, 1.65),
      walker({{9.1, 13.9}, {9.1, 6.8}, {30.0, 6.6}}, 1.0, 7.0, 1.71),
      walker({{20.55, -2.2}, {20.55, 6.5}, {20.5, 9.3}}, 1.0, 0.0, 1.83),
      walker({{19.25, -2.0}, {19.25, 6.6}, {9.1, 6.8}, {9.1, 1.5}}, 1.2, 15.0, 1.60),
      walker({{32.2, 1.6}, {32.0, 6.6}, {23.2, 6.9}, {23.2, 14.0}}, 1.1, 5.0, 1.75),
      walker({{24.2, 13.8}, {24.2, 1.5}}, 0.8, 2.0, 1.55),
      walker({{6.5, -1.4}, {34.0, -1.4}}, 1.0, 9.0, 1.88),
      walker({{35.9, 11.3}, {35.9, 7.2}, {38.8, 6.8}}, 0.9, 4.0, 1.68),
  };
}

}  // namespace

World lobby() {
  const AlignedBox3d extent(Vector3d(-0.2, -3.2, -0.1),
                            Vector3d(kLength + 0.2, kWidth + 0.8, kHeight + 0.1));
  World world{VoxelGrid(kBuildingVoxelSize, extent)};
  world.glass.emplace(kBuildingVoxelSize, extent);
  world.glassReturn = 0.15;

  buildShell(world.solid);
  carveNiches(world.solid);
  buildGlassFront(world.solid, *world.glass);
  buildTerrace(world.solid);
  buildPillars(world.solid);
  buildPartitions(world.solid);
  buildStairs(world.solid);

  CRandomGenerator random(kLayoutSeed);
  furnish(random, world.solid);
  scatter(looseFurniture(random), random, world.solid);
  hangLamps(random, world.solid);
  world.people = visitors();
  return world;
}

}  // namespace mrpt::fusion::sim
