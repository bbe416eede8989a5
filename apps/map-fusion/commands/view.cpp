// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * `map-fusion view`. */

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>

#include "commands/commands.h"
#include "fusion_base/error_text.h"
#include "fusion_base/files.h"
#include "fusion_base/printable.h"
#include "fusion_report/page/page.h"
#include "inputs.h"
#include "pages.h"

namespace fs = std::filesystem;

namespace map_fusion {
namespace {

bool holdsPage(const std::string& path) {
  return mrpt::fusion::withPath(
      path, [&] { return mrpt::fusion::isPage(mrpt::fusion::beginningOf(path)); });
}

/** Returns a file for the page of a map, in a new folder for temporary files. The page stays there:
 * the browser reads it after this program has ended. */
std::string newPage(const std::string& map) {
  std::string folder = (fs::temp_directory_path() / "map-fusion-XXXXXX").string();
  if (!::mkdtemp(folder.data()))
    throw std::runtime_error(folder + ": the folder cannot be made (-o names a file for the page)");
  return (fs::path(folder) / fs::path(map).filename().replace_extension(".html")).string();
}

/** Writes the page of a map or of the maps of a mission. \return The file. */
std::string writePage(RunContext& run, const std::string& map, const std::string& wanted) {
  drawMapsPage(run, loadFileOfRobots(run, "map", map));
  const std::string page = wanted.empty() ? newPage(map) : wanted;
  mrpt::fusion::writeFileAtomically(page, mrpt::fusion::toPage(run.report, run.page_scene));
  run.page_scene.clear();  // it is written
  return page;
}

}  // namespace

bool runView(RunContext& run) {
  const std::string& input = run.args.maps[0];
  const bool is_page = holdsPage(input);
  if (is_page && !run.args.page.empty()) throw std::runtime_error(input + ": is a page already");
  const std::string page = is_page ? input : writePage(run, input, run.args.page);
  if (page == mrpt::fusion::kStandardOutput) return true;
  const bool is_open = openPage(page);
  std::cout << (is_open ? "opened " : "open in a browser: ")
            << mrpt::fusion::printable(fs::absolute(page).string()) << "\n";
  return true;
}

}  // namespace map_fusion
