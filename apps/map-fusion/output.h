// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/edges.h>

#include <string>

/** Long work's progress: one line on stderr, rewritten, if stderr is a terminal. */
class Progress {
 public:
  explicit Progress(bool wanted);
  ~Progress() { clear(); }
  void show(const std::string& text);
  void clear();

 private:
  bool on_;
  bool shown_ = false;
};

/** Throws unless a file can be created there, so that a long run does not fail at its end.
 * \exception std::runtime_error "<path>: <reason>"; also if it is one of the inputs. */
void checkWritable(const std::string& path, const std::vector<std::string>& inputs);

/** Edge voxels as a PLY point cloud: x y z, the edge's direction as nx ny nz, probability,
 * linearity. */
std::string toPly(const mrpt::fusion::EdgeVoxels& edges);
