// SPDX-License-Identifier: BSD-3-Clause
#include "furniture.h"

namespace mrpt::fusion::sim {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

/** A box by its middle in x and y, its size in x and y, and its height range [m]. */
AlignedBox3d block(double x, double y, double length, double width, double bottom, double top) {
  return {Vector3d(x - length / 2, y - width / 2, bottom),
          Vector3d(x + length / 2, y + width / 2, top)};
}

/** Four legs at the corners of a rectangle around the origin [m]. */
void addLegs(double length, double width, double top, Furniture& piece) {
  for (const double x : {-length / 2, length / 2})
    for (const double y : {-width / 2, width / 2}) piece.push_back(block(x, y, 0.07, 0.07, 0, top));
}

Eigen::Isometry3d poseOf(const Spot& spot) {
  return Eigen::Translation3d(spot.at) * Eigen::AngleAxisd(spot.yaw, Vector3d::UnitZ());
}

AlignedBox3d turned(const AlignedBox3d& box, const Eigen::Isometry3d& pose) {
  AlignedBox3d extent;
  for (int corner = 0; corner < 8; ++corner)
    extent.extend(pose * box.corner(static_cast<AlignedBox3d::CornerType>(corner)));
  return extent;
}

}  // namespace

Furniture chair() {
  Furniture piece{block(0, 0, 0.45, 0.45, 0.40, 0.48), block(0, -0.2, 0.45, 0.08, 0.48, 0.92)};
  addLegs(0.38, 0.38, 0.40, piece);
  return piece;
}

Furniture armchair() {
  return {block(0, 0, 0.85, 0.80, 0.10, 0.42), block(0, -0.33, 0.85, 0.16, 0.42, 0.80),
          block(-0.36, 0, 0.14, 0.80, 0.42, 0.60), block(0.36, 0, 0.14, 0.80, 0.42, 0.60)};
}

Furniture table(double length, double width) {
  Furniture piece{block(0, 0, length, width, 0.70, 0.76)};
  addLegs(length - 0.12, width - 0.12, 0.70, piece);
  return piece;
}

Furniture bench(double length) {
  return {block(0, 0, length, 0.45, 0.38, 0.46), block(-length / 2 + 0.2, 0, 0.08, 0.40, 0, 0.38),
          block(length / 2 - 0.2, 0, 0.08, 0.40, 0, 0.38)};
}

Furniture bin() { return {block(0, 0, 0.38, 0.38, 0, 0.85)}; }

Furniture signStand() {
  return {block(0, 0, 0.75, 0.08, 0.30, 1.95), block(0, 0, 0.60, 0.40, 0, 0.06),
          block(-0.3, 0, 0.08, 0.08, 0, 0.30), block(0.3, 0, 0.08, 0.08, 0, 0.30)};
}

Furniture hangingLamp() {
  return {block(0, 0, 0.07, 0.07, -0.75, 0), block(0, 0, 0.45, 0.45, -1.00, -0.75)};
}

Furniture hangingSign() {
  return {block(0, 0, 1.60, 0.08, -0.80, -0.40), block(-0.6, 0, 0.07, 0.07, -0.40, 0),
          block(0.6, 0, 0.07, 0.07, -0.40, 0)};
}

Furniture plant(random::CRandomGenerator& random) {
  Furniture piece{block(0, 0, 0.50, 0.50, 0, 0.50), block(0, 0, 0.07, 0.07, 0.50, 1.10)};
  for (int leaf = 0; leaf < 30; ++leaf) {
    const double x = random.drawGaussian1D(0, 0.15), y = random.drawGaussian1D(0, 0.15);
    const double z = random.drawUniform(0.65, 1.75);
    piece.push_back(block(x, y, 0.12, 0.12, z, z + 0.09));
  }
  return piece;
}

Furniture desk(double length) {
  return {block(0, 0.38, length, 0.76, 0.70, 0.76),
          block(-length / 2 + 0.2, 0.38, 0.38, 0.66, 0.05, 0.70),
          block(length / 2 - 0.04, 0.38, 0.08, 0.70, 0, 0.70),
          block(0.15, 0.20, 0.55, 0.09, 0.86, 1.20), block(0.15, 0.20, 0.10, 0.10, 0.76, 0.86)};
}

Furniture shelf(double length, double height) {
  Furniture piece{block(0, 0.04, length, 0.08, 0, height),
                  block(-length / 2 + 0.04, 0.18, 0.08, 0.36, 0, height),
                  block(length / 2 - 0.04, 0.18, 0.08, 0.36, 0, height)};
  for (double board = 0.05; board < height; board += 0.40)
    piece.push_back(block(0, 0.18, length, 0.36, board, board + 0.07));
  return piece;
}

Furniture cupboard(double length, double height, double depth) {
  return {block(0, depth / 2, length, depth, 0, height)};
}

Furniture receptionDesk() {
  return {block(0, -0.15, 4.2, 0.30, 0, 1.10),       block(0, 0.35, 4.2, 0.70, 0.66, 0.74),
          block(-1.95, 0.75, 0.30, 1.5, 0, 1.10),    block(1.95, 0.45, 0.30, 0.90, 0, 0.74),
          block(-0.8, 0.30, 0.55, 0.09, 0.84, 1.22), block(-0.8, 0.30, 0.10, 0.10, 0.74, 0.84),
          block(0.9, 0.30, 0.55, 0.09, 0.84, 1.22),  block(0.9, 0.30, 0.10, 0.10, 0.74, 0.84)};
}

void place(const Furniture& piece, const Spot& spot, VoxelGrid& grid) {
  const Eigen::Isometry3d pose = poseOf(spot);
  const Eigen::Isometry3d inverse = pose.inverse();
  for (const AlignedBox3d& part : piece)
    grid.fillWhere(turned(part, pose),
                   [&](const Vector3d& centre) { return part.contains(inverse * centre); });
}

bool fits(const Furniture& piece, const Spot& spot, double gap, const VoxelGrid& grid) {
  AlignedBox3d extent = extentOf(piece, spot);
  extent.min().head<2>().array() -= gap;
  extent.max().head<2>().array() += gap;
  return !grid.anyOccupied(extent);
}

AlignedBox3d extentOf(const Furniture& piece, const Spot& spot) {
  AlignedBox3d extent;
  for (const AlignedBox3d& part : piece) extent.extend(turned(part, poseOf(spot)));
  return extent;
}

}  // namespace mrpt::fusion::sim
