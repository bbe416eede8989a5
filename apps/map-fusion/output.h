// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

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

/** Whether a path (may be empty) names what standard output goes to. */
bool isStandardOutput(const std::string& path);

/** Throws unless a file can be created there, so that a long run does not fail at its end.
 * \exception std::runtime_error "<path>: <reason>"; also if it is one of the inputs. */
void checkWritable(const std::string& path, const std::vector<std::string>& inputs);
