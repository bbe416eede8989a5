// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Names robots after their files. */
#include "fusion_base/file_names.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace fs = std::filesystem;

namespace mrpt::fusion {

std::vector<std::string> namesOf(const std::vector<std::string>& paths) {
  std::vector<std::string> names;
  std::vector<fs::path> files, folders;
  for (const auto& path : paths) {
    files.push_back(fs::absolute(path).lexically_normal());
    folders.push_back(files.back().parent_path());
    names.push_back(files.back().filename().replace_extension().string());
  }
  const auto areDistinct = [&] {
    for (size_t i = 0; i < paths.size(); i++)
      for (size_t j = 0; j < i; j++)
        if (names[i] == names[j] && files[i] != files[j]) return false;
    return true;
  };
  const auto isTop = [](const fs::path& folder) { return !folder.has_relative_path(); };
  while (!areDistinct() && !std::all_of(folders.begin(), folders.end(), isTop))
    for (size_t i = 0; i < paths.size(); i++) {
      if (isTop(folders[i])) continue;
      names[i] = folders[i].filename().string() + "_" + names[i];
      folders[i] = folders[i].parent_path();
    }
  return names;
}

bool isSameFile(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return a == b || fs::equivalent(a, b, ignored);
}

}  // namespace mrpt::fusion
