// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Shows progress, and checks and writes output files. */

#include "output.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "fusion_base/files.h"
#include "fusion_base/printable.h"
#include "fusion_octree/files.h"
#include "mrpt_maps.h"

namespace fs = std::filesystem;

namespace map_fusion {

namespace {

/** Returns what the system knows of an output. Returns nothing if it does not exist. In contrast to
 * std::filesystem::equivalent(), pipes have an identity, too. */
std::optional<struct stat> identityOf(std::string_view output) {
  struct stat file {};
  const int failed = output == mrpt::fusion::kStandardOutput
                         ? ::fstat(STDOUT_FILENO, &file)
                         : ::stat(std::string(output).c_str(), &file);
  return failed ? std::nullopt : std::optional(file);
}

bool isSameFile(const struct stat& a, const std::optional<struct stat>& b) {
  return b && a.st_dev == b->st_dev && a.st_ino == b->st_ino;
}

}  // namespace

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
  const auto file = identityOf(path);
  return file && isSameFile(*file, identityOf(mrpt::fusion::kStandardOutput));
}

bool isSameOutput(const std::string& a, const std::string& b) {
  if (a == b && a == mrpt::fusion::kStandardOutput) return true;
  const auto file_a = identityOf(a);
  const auto file_b = identityOf(b);
  if (file_a && isSameFile(*file_a, file_b)) return !S_ISCHR(file_a->st_mode);
  if (file_a || file_b) return false;
  std::error_code ignored;
  return fs::weakly_canonical(fs::absolute(a), ignored) ==
         fs::weakly_canonical(fs::absolute(b), ignored);
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

bool isDevice(const std::string& path) {
  std::error_code ignored;
  return path == mrpt::fusion::kStandardOutput ||
         (fs::exists(path, ignored) && !fs::is_regular_file(path, ignored));
}

MapExtension mapExtensionOf(const std::string& path) {
  if (isDevice(path)) return MapExtension::OfMaps;
  const fs::path file(path);
  const bool is_packed = file.extension() == ".gz";
  const fs::path extension = is_packed ? file.stem().extension() : file.extension();
  const auto is_among = [&](std::initializer_list<const char*> known) {
    return std::find(known.begin(), known.end(), extension) != known.end();
  };
  if (is_among({".ot", ".bt"})) return is_packed ? MapExtension::OfOthers : MapExtension::OfMaps;
  if (is_among({".gridmap", ".map", ".simplemap"}) || (is_packed && extension.empty()))
    return MapExtension::OfMaps;
  return is_among({".bag", ".csv", ".g2o", ".html", ".ini", ".jpg", ".json",   ".las",
                   ".laz", ".pcd", ".pdf", ".pgm",  ".ply", ".png", ".rawlog", ".svg",
                   ".tum", ".txt", ".xyz", ".yaml", ".yml", ".zip"})
             ? MapExtension::OfOthers
             : MapExtension::Unknown;
}

void saveMap(const std::shared_ptr<const octomap::OcTree>& map, const std::string& path,
             const mrpt::fusion::Sources& sources) {
  const std::string extension = fs::path(path).extension();
  if (extension == ".ot" || extension == ".bt" || path == mrpt::fusion::kStandardOutput)
    mrpt::fusion::saveOcTree(*map, path);
  else
    mrptMaps().save({map, nullptr, nullptr, {}, sources}, path);
}

}  // namespace map_fusion
