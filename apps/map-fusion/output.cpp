// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Shows progress, and checks and writes output files. */

#include "output.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include "fusion_base/files.h"
#include "fusion_base/printable.h"
#include "fusion_octree/files.h"
#include "mrpt_maps.h"

namespace fs = std::filesystem;

namespace map_fusion {

Progress::Progress(bool wanted)
    : terminal_(wanted && ::isatty(STDERR_FILENO) == 1
                    ? ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1)
                    : -1) {}

Progress::~Progress() {
  clear();
  if (terminal_ >= 0) ::close(terminal_);
}

void Progress::show(const std::string& text) {
  if (terminal_ < 0) return;
  ::dprintf(terminal_, "\r\033[K%s", mrpt::fusion::printable(text).c_str());
  shown_ = true;
}

void Progress::clear() {
  if (shown_) ::dprintf(terminal_, "\r\033[K");
  shown_ = false;
}

bool isStandardOutput(const std::string& path) {
  if (path == mrpt::fusion::kStandardOutput) return true;
  struct stat file {};
  struct stat out {};
  return ::stat(path.c_str(), &file) == 0 && ::fstat(STDOUT_FILENO, &out) == 0 &&
         file.st_dev == out.st_dev && file.st_ino == out.st_ino;
}

bool isSameOutput(const std::string& a, const std::string& b) {
  const auto pathOf = [](const std::string& path) -> fs::path {
    return path == mrpt::fusion::kStandardOutput ? "/dev/stdout" : path;
  };
  std::error_code ignored;
  if (a == b && a == mrpt::fusion::kStandardOutput) return true;
  if (fs::equivalent(pathOf(a), pathOf(b), ignored))
    return !fs::is_character_file(pathOf(a), ignored);
  return fs::weakly_canonical(fs::absolute(pathOf(a)), ignored) ==
             fs::weakly_canonical(fs::absolute(pathOf(b)), ignored) &&
         !fs::exists(pathOf(a), ignored);
}

void checkWritable(const std::string& path, const std::vector<std::string>& inputs) {
  if (path == mrpt::fusion::kStandardOutput) return;
  std::error_code ignored;
  for (const auto& input : inputs)
    if (fs::equivalent(path, input, ignored))
      throw std::runtime_error(path + ": is an input and is not overwritten");
  if (fs::is_directory(path, ignored)) throw std::runtime_error(path + ": is a directory");
  std::error_code is_new;
  const fs::path target = fs::canonical(path, is_new);  // the target of a link
  const fs::path parent = (is_new ? fs::absolute(path) : target).parent_path();
  if (!fs::is_directory(parent, ignored))
    throw std::runtime_error(path + ": there is no directory " + parent.string());
  const bool exists = fs::exists(path, ignored);
  const bool in_place = exists && !fs::is_regular_file(path, ignored);  // see writeFileAtomically()
  if ((exists && ::access(path.c_str(), W_OK) != 0) ||
      (!in_place && ::access(parent.c_str(), W_OK) != 0))
    throw std::runtime_error(path + ": cannot be written: permission denied");
}

void saveMap(const std::shared_ptr<const octomap::OcTree>& map, const std::string& path) {
  const std::string extension = fs::path(path).extension();
  if (extension == ".ot" || extension == ".bt" || path == mrpt::fusion::kStandardOutput)
    mrpt::fusion::saveOcTree(*map, path);
  else
    mrptMaps().save({map, nullptr, nullptr, {}}, path);
}

}  // namespace map_fusion
