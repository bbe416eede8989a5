// SPDX-License-Identifier: BSD-3-Clause
// The peers, with the settings of PCL's own documentation where the protocol leaves a choice.
#include <mrpt/fusion/voxels.h>
#include <pcl/features/normal_3d.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/ndt.h>

#include <stdexcept>
#include <vector>

#include "methods.h"

namespace mrpt::fusion::benchmark {
namespace {

template <class Point>
typename pcl::PointCloud<Point>::Ptr toCloud(const std::vector<Eigen::Vector3f>& points) {
  auto cloud = std::make_shared<pcl::PointCloud<Point>>();
  cloud->resize(points.size());
  for (size_t i = 0; i < points.size(); i++) (*cloud)[i].getVector3fMap() = points[i];
  return cloud;
}

template <class Point>
typename pcl::PointCloud<Point>::Ptr centresOf(const octomap::OcTree& map) {
  return toCloud<Point>(extractOccupiedVoxels(map).centre);
}

/** Makes the number of iterations, which PCL keeps protected, readable. */
template <class Base>
struct Counting : Base {
  unsigned iterations() const { return static_cast<unsigned>(this->nr_iterations_); }
};

template <class Point, class Algorithm>
class PclMethod : public Method {
 public:
  void prepare(const MapPair& pair) override {
    const auto model = centresOf<Point>(*pair.a);
    const auto scene = centresOf<Point>(*pair.b);
    complete(*model);
    complete(*scene);
    algorithm_.setMaxCorrespondenceDistance(kGate);
    configure(algorithm_);
    algorithm_.setInputTarget(model);
    algorithm_.setInputSource(scene);
    algorithm_.setMaximumIterations(kMaxIterations);
  }

  void warmUp(const MapPair& pair) override {  // PCL makes trees and covariances when it needs them
    algorithm_.setMaximumIterations(1);
    align(pair.T_a_b);
    algorithm_.setMaximumIterations(kMaxIterations);
  }

  Registration align(const Eigen::Isometry3d& start) override {
    pcl::PointCloud<Point> moved;
    algorithm_.align(moved, start.matrix().cast<float>());
    const Eigen::Matrix4d T = algorithm_.getFinalTransformation().template cast<double>();
    return {Eigen::Isometry3d(T), algorithm_.iterations(), std::nullopt};
  }

 protected:
  virtual void complete(pcl::PointCloud<Point>&) const {}
  virtual void configure(Algorithm& algorithm) const { algorithm.setTransformationEpsilon(1e-8); }

 private:
  Algorithm algorithm_;
};

using Point = pcl::PointXYZ;
using Icp = PclMethod<Point, Counting<pcl::IterativeClosestPoint<Point, Point>>>;

class IcpToPlane
    : public PclMethod<
          pcl::PointNormal,
          Counting<pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal>>> {
  void complete(pcl::PointCloud<pcl::PointNormal>& cloud) const override {
    constexpr int kNeighbours = 20;  // as PCL's GICP
    pcl::NormalEstimation<pcl::PointNormal, pcl::PointNormal> estimation;
    estimation.setInputCloud(cloud.makeShared());
    estimation.setKSearch(kNeighbours);
    estimation.compute(cloud);  // writes the normals and leaves the coordinates
  }
};

using Gicp = Counting<pcl::GeneralizedIterativeClosestPoint<Point, Point>>;
class GicpMethod : public PclMethod<Point, Gicp> {
  void configure(Gicp&) const override {}  // its defaults
};

using Ndt = Counting<pcl::NormalDistributionsTransform<Point, Point>>;
class NdtMethod : public PclMethod<Point, Ndt> {
  void configure(Ndt& ndt) const override {
    ndt.setTransformationEpsilon(1e-8);
    ndt.setStepSize(0.1);
    ndt.setResolution(1.0F);
  }
};

}  // namespace

std::unique_ptr<Method> makePclMethod(const std::string& name) {
  if (name == "icp") return std::make_unique<Icp>();
  if (name == "icp_plane") return std::make_unique<IcpToPlane>();
  if (name == "gicp") return std::make_unique<GicpMethod>();
  if (name == "ndt") return std::make_unique<NdtMethod>();
  throw std::invalid_argument("unknown method '" + name + "'");
}

std::vector<Eigen::Isometry3d> icpSteps(const std::vector<Eigen::Vector3f>& model,
                                        const std::vector<Eigen::Vector3f>& scene,
                                        const Eigen::Isometry3d& start, double gate,
                                        unsigned iterations) {
  pcl::IterativeClosestPoint<Point, Point> icp;
  icp.setInputTarget(toCloud<Point>(model));
  icp.setInputSource(toCloud<Point>(scene));
  icp.setMaxCorrespondenceDistance(gate);
  icp.setMaximumIterations(1);
  std::vector<Eigen::Isometry3d> poses;
  Eigen::Isometry3d T = start;
  pcl::PointCloud<Point> moved;
  for (unsigned i = 0; i < iterations; i++) {
    icp.align(moved, T.matrix().cast<float>());
    T.matrix() = icp.getFinalTransformation().cast<double>();
    poses.push_back(T);
  }
  return poses;
}

}  // namespace mrpt::fusion::benchmark
