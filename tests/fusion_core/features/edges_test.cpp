// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_core/features/edges.h"

#include <gtest/gtest.h>
#include <mrpt/fusion/edges.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <string>

#include "fusion_core/features/surfaces.h"
#include "fusion_core/map/eigen_solvers.h"
#include "fusion_octree/resampling.h"
#include "support/test_maps.h"

namespace mrpt::fusion::test::edges_test {
namespace {

constexpr double kResolution = 0.1;

/** Different cells of a cube, with random probabilities. */
OccupiedVoxels randomVoxels(size_t n, int side, std::mt19937& random) {
  std::uniform_int_distribution<int> coordinate(0, side - 1);
  std::set<Cell> cells;
  while (cells.size() < n)
    cells.insert({coordinate(random), coordinate(random), coordinate(random)});
  OccupiedVoxels v = voxelsAt({cells.begin(), cells.end()}, kResolution);
  for (auto& p : v.probability) p = std::uniform_real_distribution<float>(0.5F, 1.F)(random);
  return v;
}

std::vector<size_t> neighboursOf(const OccupiedVoxels& v, size_t i, double radius) {
  std::vector<size_t> neighbours;
  for (size_t j = 0; j < v.size(); j++)
    if ((v.centre[i] - v.centre[j]).cast<double>().norm() < radius) neighbours.push_back(j);
  return neighbours;
}

// ---------------------------------------------------------------- lines 2-6: normals

TEST(Normals, AreTheLeastPrincipalComponentOfTheNeighbours) {
  std::mt19937 random(1);
  const OccupiedVoxels v = randomVoxels(400, 12, random);
  EdgeParams params;
  params.normal_radius = 0.27;  // no distance of the grid is as long: no neighbour is on the rim
  params.max_surface_variation = 0.15;
  const auto normals = computeSurfaces(v, params).normal;
  ASSERT_EQ(normals.size(), v.size());

  size_t with_normal = 0, without = 0;
  for (size_t i = 0; i < v.size(); i++) {
    const auto neighbours = neighboursOf(v, i, params.normal_radius);
    Eigen::Matrix3Xd points(3, neighbours.size());
    for (size_t k = 0; k < neighbours.size(); k++)
      points.col(k) = v.centre[neighbours[k]].cast<double>();
    points.colwise() -= points.rowwise().mean().eval();
    const SymmetricEigen<3> pca(points * points.transpose());
    const Eigen::Vector3d spread = pca.eigenvalues / neighbours.size();
    if (std::abs(spread[0] / spread.sum() - params.max_surface_variation) < 1e-6) continue;
    if (spread[1] - spread[0] < 1e-5) continue;  // any direction of a plane would do

    if (neighbours.size() < 3 || spread[0] / spread.sum() > params.max_surface_variation) {
      EXPECT_TRUE(normals[i].isZero()) << i;
      without++;
    } else {
      EXPECT_NEAR(normals[i].norm(), 1, 1e-5) << i;
      EXPECT_NEAR(std::abs(normals[i].cast<double>().dot(pca.eigenvectors.col(0))), 1, 1e-4) << i;
      with_normal++;
    }
  }
  EXPECT_GT(with_normal, 50);
  EXPECT_GT(without, 50);
}

TEST(Normals, OfSolidsBarsAndThinWallsHaveTheVariationOfTheirEigenvalues) {
  // Where eigenvalues are the same, or next to it, and where the least is zero.
  EdgeParams params;
  params.normal_radius = 10;
  params.max_surface_variation = 0.5;
  for (const Cell& size : std::vector<Cell>{{3, 3, 3},
                                            {4, 4, 4},
                                            {2, 2, 9},
                                            {2, 3, 9},
                                            {9, 9, 1},
                                            {9, 8, 1},
                                            {9, 9, 2},
                                            {9, 2, 1}}) {
    std::vector<Cell> cells;
    for (int x = 0; x < size[0]; x++)
      for (int y = 0; y < size[1]; y++)
        for (int z = 0; z < size[2]; z++) cells.push_back({x, y, z});
    const auto surfaces = computeSurfaces(voxelsAt(cells, kResolution), params);
    Eigen::Vector3d spread;  // of whole numbers from 0 on
    for (int axis = 0; axis < 3; axis++) spread[axis] = size[axis] * size[axis] - 1;
    const double variation = spread.minCoeff() / spread.sum();
    for (size_t i = 0; i < cells.size(); i++) {
      ASSERT_NEAR(surfaces.variation[i], variation, 1e-5) << size[0] << size[1] << size[2];
      ASSERT_NEAR(surfaces.normal[i].norm(), 1, 1e-5);
      for (int axis = 0; axis < 3; axis++)  // only across what is thin
        if (spread[axis] > spread.minCoeff()) {
          ASSERT_NEAR(surfaces.normal[i][axis], 0, 1e-4);
        }
    }
  }
}

TEST(Normals, OfFewerThanThreeVoxelsOrOfALineAreZero) {
  for (const std::vector<Cell>& cells : {std::vector<Cell>{{0, 0, 0}},
                                         {{0, 0, 0}, {1, 0, 0}},
                                         {{0, 0, 0}, {0, 1, 0}, {0, 2, 0}},
                                         {{0, 0, 0}, {1, 1, 1}, {-1, -1, -1}}})
    for (const auto& normal : computeSurfaces(voxelsAt(cells, kResolution), EdgeParams()).normal)
      EXPECT_TRUE(normal.isZero());
}

TEST(Normals, LeastRadiusInVoxelsServesCoarseMaps) {
  // At half a metre, 0.25 m hold no neighbour; 2.5 voxels do.
  const OccupiedVoxels wall = voxelsAt({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, 0.5);
  for (const auto& normal : computeSurfaces(wall, EdgeParams()).normal)
    EXPECT_NEAR(std::abs(normal.z()), 1, 1e-6);
}

TEST(SurfacePoints, LieNearerToAClimbingPlaneThanTheVoxelsDo) {
  // A plane that climbs across the grid, voxels wherever it passes below a centre.
  const Eigen::Vector3d normal = Eigen::Vector3d(-0.3, 0.17, 1).normalized();
  std::vector<Cell> cells;
  for (int x = -15; x <= 15; x++)
    for (int y = -15; y <= 15; y++)
      cells.push_back({x, y, static_cast<int>(std::floor(0.3 * x - 0.17 * y))});
  const OccupiedVoxels v = voxelsAt(cells, kResolution);
  const Surfaces surfaces = computeSurfaces(v, EdgeParams());

  // The plane itself is where the voxels are on the whole.
  const auto spreadOf = [&](const std::vector<Eigen::Vector3f>& points) {
    double sum = 0, squares = 0, n = 0;
    for (size_t i = 0; i < points.size(); i++) {
      if (v.centre[i].head<2>().cwiseAbs().maxCoeff() > 1.2F) continue;  // the rim sees one side
      const double height = normal.dot(points[i].cast<double>());
      sum += height;
      squares += height * height;
      n++;
    }
    return std::sqrt(squares / n - sum * sum / (n * n));
  };
  EXPECT_LT(spreadOf(surfaces.point), 0.4 * spreadOf(v.centre));
  for (size_t i = 0; i < v.size(); i++) {
    const Eigen::Vector3f moved = surfaces.point[i] - v.centre[i];
    EXPECT_LT(moved.cross(surfaces.normal[i]).norm(), 1e-6) << i;  // along the normal only
  }
}

TEST(SurfacePoints, WithoutANormalAreTheCentres) {
  const OccupiedVoxels line = voxelsAt({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, kResolution);
  EXPECT_EQ(computeSurfaces(line, EdgeParams()).point, line.centre);
}

// ---------------------------------------------------------------- eq. (5)

TEST(AngleCosts, ByHandOnThreeVoxels) {
  const OccupiedVoxels row = voxelsAt({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, kResolution);
  const Eigen::Vector3f x = Eigen::Vector3f::UnitX(), z = Eigen::Vector3f::UnitZ();
  const Eigen::Vector3f tilted(0, std::sin(0.3F), std::cos(0.3F));
  EdgeParams params;
  params.min_cost_radius_voxels = 1;

  params.cost_radius = 0.25;  // all of the row
  auto costs = computeAngleCosts(row, {z, x, tilted}, params);
  EXPECT_NEAR(costs[0], (0 + 1 + std::sin(0.3)) / 3, 1e-6);
  EXPECT_NEAR(costs[1], (1 + 0 + 1) / 3.0, 1e-6);
  EXPECT_NEAR(costs[2], (std::sin(0.3) + 1 + 0) / 3, 1e-6);
  // A normal's sign does not matter, and voxels without one do not count.
  costs = computeAngleCosts(row, {-z, Eigen::Vector3f::Zero(), tilted}, params);
  EXPECT_NEAR(costs[0], std::sin(0.3) / 2, 1e-6);
  EXPECT_EQ(costs[1], 0);

  params.cost_radius = 0.15;  // only the next one
  costs = computeAngleCosts(row, {z, x, tilted}, params);
  EXPECT_NEAR(costs[0], 1 / 2.0, 1e-6);
  EXPECT_NEAR(costs[1], 2 / 3.0, 1e-6);
}

TEST(AngleCosts, AreTheMeanOverTheNeighbours) {
  std::mt19937 random(2);
  const OccupiedVoxels v = randomVoxels(400, 12, random);
  std::normal_distribution<float> normal;
  std::vector<Eigen::Vector3f> normals(v.size());
  for (auto& n : normals)
    n = Eigen::Vector3f(normal(random), normal(random), normal(random)).normalized();
  EdgeParams params;
  params.cost_radius = 0.61;
  const auto costs = computeAngleCosts(v, normals, params);
  for (size_t i = 0; i < v.size(); i++) {
    const auto neighbours = neighboursOf(v, i, params.cost_radius);
    double sum = 0;
    for (const size_t j : neighbours) sum += normals[j].cross(normals[i]).norm();
    ASSERT_NEAR(costs[i], sum / static_cast<double>(neighbours.size()), 1e-5) << i;
  }
}

// ---------------------------------------------------------------- Algorithm 1: where edges are

struct Segment {
  Eigen::Vector3d from, to;

  double length() const { return (to - from).norm(); }
  Eigen::Vector3d direction() const { return (to - from) / length(); }
  /** How far along the segment its point nearest to \a p is. */
  double along(const Eigen::Vector3d& p) const {
    return std::clamp((p - from).dot(direction()), 0.0, length());
  }
  double distanceTo(const Eigen::Vector3d& p) const {
    return (p - from - along(p) * direction()).norm();
  }
};

/** The twelve edges of MapWriter::shell(low, high), amid its voxels. */
std::vector<Segment> shellEdges(const Cell& low, const Cell& high) {
  std::vector<Segment> edges;
  for (int axis = 0; axis < 3; axis++)
    for (int i = 0; i < 4; i++) {
      Cell from = low, to = high;
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      from[u] = to[u] = (i & 1) ? high[u] : low[u];
      from[v] = to[v] = (i & 2) ? high[v] : low[v];
      edges.push_back({centreOf(from, kResolution), centreOf(to, kResolution)});
    }
  return edges;
}

const Segment& nearestTo(const Eigen::Vector3d& p, const std::vector<Segment>& edges) {
  return *std::min_element(edges.begin(), edges.end(), [&](const auto& a, const auto& b) {
    return a.distanceTo(p) < b.distanceTo(p);
  });
}

/** Share of the points along true edges that have an edge voxel within two voxels. */
double coverage(const std::vector<Segment>& truth, const EdgeVoxels& found) {
  size_t points = 0, covered = 0;
  for (const Segment& s : truth)
    for (double at = 0; at <= s.length(); at += kResolution / 2) {
      const Eigen::Vector3f p = (s.from + at * s.direction()).cast<float>();
      points++;
      covered += std::any_of(found.centre.begin(), found.centre.end(), [&](const auto& c) {
        return (c - p).squaredNorm() <= 4 * kResolution * kResolution;
      });
    }
  return static_cast<double>(covered) / static_cast<double>(points);
}

/** The edge voxels of a world seen from another frame, moved back into the world's. */
EdgeVoxels edgesSeenFrom(const octomap::OcTree& world, const Eigen::Isometry3d& T,
                         size_t* voxels = nullptr, const EdgeParams& params = {}) {
  const auto map = mrpt::fusion::transformOcTree(world, T, kResolution);
  const OccupiedVoxels occupied = extractOccupiedVoxels(*map);
  if (voxels) *voxels = occupied.size();
  EdgeVoxels edges = extractEdges(occupied, params);
  for (auto& c : edges.centre) c = T.inverse().cast<float>() * c;
  for (auto& c : edges.covariance) c.eigenvectors = T.linear().transpose() * c.eigenvectors;
  return edges;
}

constexpr Cell kRoomLow{0, 0, 0}, kRoomHigh{59, 49, 27};        // 6 x 5 x 2.8 m
constexpr Cell kPillarLow{20, 15, 0}, kPillarHigh{30, 25, 27};  // 1.1 m, floor to ceiling

std::unique_ptr<octomap::OcTree> room() {
  return MapWriter(kResolution).shell(kRoomLow, kRoomHigh, kOccupied).pruned();
}

struct Frame {
  std::string name;
  Eigen::Isometry3d T;
};
std::ostream& operator<<(std::ostream& out, const Frame& f) { return out << f.name; }

class EdgesOfARoom : public testing::TestWithParam<Frame> {
 protected:
  void SetUp() override { found = edgesSeenFrom(*room(), GetParam().T, &voxels); }

  const std::vector<Segment> truth = shellEdges(kRoomLow, kRoomHigh);
  EdgeVoxels found;
  size_t voxels = 0;
};

TEST_P(EdgesOfARoom, LieOnItsTrueEdges) {
  // Resampling itself moves a wall by up to half a voxel along each axis.
  const auto shareWithin = [&](double distance) {
    const auto near = std::count_if(found.centre.begin(), found.centre.end(), [&](const auto& c) {
      const Eigen::Vector3d p = c.template cast<double>();
      return nearestTo(p, truth).distanceTo(p) <= distance;
    });
    return static_cast<double>(near) / static_cast<double>(found.size());
  };
  EXPECT_GE(shareWithin(1.5 * kResolution), 0.90);
  EXPECT_GE(shareWithin(2.0 * kResolution), 0.95);
}

// Everything in most poses; where a wall climbs across the grid at a small or a diagonal angle,
// about three quarters: there its corner is seldom just a voxel, and one voxel off bends by 101
// degrees.
TEST_P(EdgesOfARoom, CoverItsTrueEdges) { EXPECT_GE(coverage(truth, found), 0.70); }

TEST_P(EdgesOfARoom, AreAFewPercentOfItsVoxels) {
  EXPECT_GE(found.size(), 0.03 * voxels);
  EXPECT_LE(found.size(), 0.10 * voxels);
}

TEST_P(EdgesOfARoom, PointAlongItsTrueEdges) {
  // Not at the corners, where three edges meet in one neighbourhood.
  const double corner = EdgeParams().direction_radius + 1.5 * kResolution;
  size_t away_from_corners = 0, along = 0;
  for (size_t i = 0; i < found.size(); i++) {
    const Eigen::Vector3d p = found.centre[i].cast<double>();
    const Segment& edge = nearestTo(p, truth);
    const double at = edge.along(p);
    if (at < corner || at > edge.length() - corner) continue;
    away_from_corners++;
    along +=
        std::abs(found.covariance[i].direction().dot(edge.direction())) > std::cos(15 * kDegree);
  }
  EXPECT_GE(away_from_corners, found.size() / 3);
  EXPECT_GE(along, 0.9 * away_from_corners);
}

// Yaw of 45 deg, and some near 0 deg, alias worst with the grid.
INSTANTIATE_TEST_SUITE_P(Edges, EdgesOfARoom,
                         testing::Values(Frame{"own", Eigen::Isometry3d::Identity()},
                                         Frame{"yaw_5", poseOf(0.05, 0.1, 0.05, 5)},
                                         Frame{"yaw_45", poseOf(1, 2, 0.3, 45)},
                                         Frame{"tilted", poseOf(0.33, -2, 0.03, 17, 5, -3)},
                                         Frame{"tumbled", poseOf(0.05, 0.05, 0.05, 73, -40, 20)}),
                         [](const auto& frame) { return frame.param.name; });

TEST(Edges, ConcaveAndConvexCornersAreBothFound) {
  const auto world = MapWriter(kResolution)
                         .shell(kRoomLow, kRoomHigh, kOccupied)
                         .shell(kPillarLow, kPillarHigh, kOccupied)
                         .pruned();
  const EdgeVoxels found = edgesSeenFrom(*world, poseOf(0.33, -2, 0.03, 17, 5, -3));
  const auto uprights = [](std::vector<Segment> edges) {  // the last four
    return std::vector<Segment>(edges.end() - 4, edges.end());
  };
  EXPECT_GE(coverage(uprights(shellEdges(kRoomLow, kRoomHigh)), found), 0.85) << "concave";
  EXPECT_GE(coverage(uprights(shellEdges(kPillarLow, kPillarHigh)), found), 0.85) << "convex";
}

TEST(Edges, AFlatWallHasNone) {
  const auto wall = MapWriter(kResolution).box({0, 0, 0}, {0, 59, 29}, kOccupied).pruned();
  for (const auto& T : {poseOf(0, 0, 0, 0), poseOf(0, 0, 0, 45), poseOf(0.33, -2, 0.03, 17, 5, -3),
                        poseOf(0, 0, 0, 73, -40, 20)})
    EXPECT_EQ(edgesSeenFrom(*wall, T).size(), 0);
}

TEST(Edges, NoVoxelsHaveNone) {
  EXPECT_EQ(extractEdges(extractOccupiedVoxels(octomap::OcTree(kResolution)), EdgeParams()).size(),
            0);
}

TEST(Edges, SpeckOfClutterFarAwayIsAnOutlier) {
  // Two strips, three voxels high, that meet in an edge 3.5 m beyond the wall.
  const auto world = MapWriter(kResolution)
                         .shell(kRoomLow, kRoomHigh, kOccupied)
                         .box({95, 20, 10}, {95, 32, 12}, kOccupied)
                         .box({95, 20, 10}, {107, 20, 12}, kOccupied)
                         .pruned();
  const auto beyondTheWall = [&](const EdgeParams& params) {
    const EdgeVoxels found = edgesSeenFrom(*world, Eigen::Isometry3d::Identity(), nullptr, params);
    return std::count_if(found.centre.begin(), found.centre.end(),
                         [](const auto& c) { return c.x() > 8; });
  };
  EdgeParams without_removal;
  without_removal.outlier_deviations = 1e9;
  EXPECT_GT(beyondTheWall(without_removal), 0);
  EXPECT_EQ(beyondTheWall(EdgeParams()), 0);
}

TEST(Edges, CarryTheProbabilityOfTheirVoxel) {
  const auto map = MapWriter(kResolution)
                       .shell(kRoomLow, kRoomHigh, kOccupied)
                       .box({0, 0, 0}, {59, 49, 3}, 1.0F)
                       .pruned();
  const EdgeVoxels found = extractEdges(extractOccupiedVoxels(*map), EdgeParams());
  size_t low = 0, high = 0;
  for (size_t i = 0; i < found.size(); i++) {
    const auto* node = map->search(found.centre[i].x(), found.centre[i].y(), found.centre[i].z());
    ASSERT_NE(node, nullptr);
    EXPECT_FLOAT_EQ(found.probability[i], static_cast<float>(node->getOccupancy()));
    (found.probability[i] < 0.8F ? low : high)++;
  }
  EXPECT_GT(low, 0);
  EXPECT_GT(high, 0);
}

// ---------------------------------------------------------------- invariance

/** A room with a pillar, its lowest corner at a cell of the grid. */
OccupiedVoxels furnishedRoomAt(const Cell& at) {
  const auto moved = [&](const Cell& c) { return Cell{c[0] + at[0], c[1] + at[1], c[2] + at[2]}; };
  return extractOccupiedVoxels(*MapWriter(kResolution)
                                    .shell(moved(kRoomLow), moved(kRoomHigh), kOccupied)
                                    .shell(moved(kPillarLow), moved(kPillarHigh), 1.5F)
                                    .pruned());
}

/** Edge voxels by their cell, as seen from \a at. */
std::map<Cell, size_t> byCell(const EdgeVoxels& edges, const Cell& at) {
  std::map<Cell, size_t> m;
  for (size_t i = 0; i < edges.size(); i++) {
    const Eigen::Array3f c = (edges.centre[i].array() / static_cast<float>(kResolution)).floor();
    m[{static_cast<int>(c.x()) - at[0], static_cast<int>(c.y()) - at[1],
       static_cast<int>(c.z()) - at[2]}] = i;
  }
  return m;
}

TEST(Edges, OfAMapMovedByWholeVoxelsAreTheMovedEdges) {
  const Cell here{0, 0, 0}, there{137, -211, 53};
  const EdgeVoxels a = extractEdges(furnishedRoomAt(here), EdgeParams());
  const EdgeVoxels b = extractEdges(furnishedRoomAt(there), EdgeParams());
  const auto in_a = byCell(a, here), in_b = byCell(b, there);
  ASSERT_GT(a.size(), 300);
  ASSERT_EQ(in_a.size(), in_b.size());
  for (auto i = in_a.begin(), j = in_b.begin(); i != in_a.end(); ++i, ++j) {
    ASSERT_EQ(i->first, j->first);
    EXPECT_EQ(a.probability[i->second], b.probability[j->second]);
  }
}

TEST(Edges, CovariancesOfAMapMovedByWholeVoxelsAreTheSame) {
  const Cell here{0, 0, 0}, there{137, -211, 53};
  const EdgeVoxels a = extractEdges(furnishedRoomAt(here), EdgeParams());
  const EdgeVoxels b = extractEdges(furnishedRoomAt(there), EdgeParams());
  const auto in_b = byCell(b, there);
  size_t different = 0;
  for (const auto& [cell, i] : byCell(a, here)) {
    const auto j = in_b.find(cell);
    ASSERT_NE(j, in_b.end());
    different += !b.covariance[j->second].matrix(0).isApprox(a.covariance[i].matrix(0), 1e-3);
  }
  EXPECT_EQ(different, 0) << "of " << a.size();
}

TEST(Edges, AreTheSameForAnyNumberOfThreads) {
  const OccupiedVoxels v = furnishedRoomAt({0, 0, 0});
  const auto extract = [&] { return extractEdges(v, EdgeParams()); };
  const EdgeVoxels one = withThreads(1, extract), two = withThreads(2, extract);
  ASSERT_GT(one.size(), 300);
  EXPECT_EQ(one.centre, two.centre);
  EXPECT_EQ(one.probability, two.probability);
  for (size_t i = 0; i < one.size(); i++) {
    ASSERT_EQ(one.covariance[i].eigenvalues, two.covariance[i].eigenvalues);
    ASSERT_EQ(one.covariance[i].eigenvectors, two.covariance[i].eigenvectors);
  }
}

}  // namespace
}  // namespace mrpt::fusion::test::edges_test
