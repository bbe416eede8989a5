// SPDX-License-Identifier: BSD-3-Clause
// fuse_two_octrees A.ot B.ot FUSED.ot: two octrees made one, without a map class of MRPT.
#include <mrpt/fusion/alignment.h>
#include <mrpt/fusion/merging.h>
#include <octomap/OcTree.h>

#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>

using Octree = std::shared_ptr<const octomap::OcTree>;

Octree octreeOf(const std::string& path) {
  std::shared_ptr<octomap::AbstractOcTree> read(octomap::AbstractOcTree::read(path));
  auto octree = std::dynamic_pointer_cast<const octomap::OcTree>(read);
  if (!octree) throw std::runtime_error(path + ": not an octree of OctoMap (.ot)");
  return octree;
}

int main(int argc, char** argv) try {
  if (argc != 4) throw std::runtime_error("usage: fuse_two_octrees A.ot B.ot FUSED.ot");
  const Octree a = octreeOf(argv[1]), b = octreeOf(argv[2]);
  const std::string path = argv[3];

  // [README]
  // a and b are std::shared_ptr<const octomap::OcTree>. They are shared, not copied.
  using namespace mrpt::fusion;
  const Options options;
  const Alignment found = align(PreparedMap(a), PreparedMap(b), Prior::none(), options);
  if (!found.evaluation.accepted) {
    for (const auto& reason : found.evaluation.against()) std::cerr << reason << "\n";
    return 3;
  }
  mergeMaps(*a, *b, found.match.T_a_b, options.merge)->write(path);  // in a's frame
  // [README]

  std::cout << found.match.T_a_b.matrix() << "\n";
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << "\n";
  return 1;
}
