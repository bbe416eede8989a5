// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Writes the manual pages and the completion of bash into a folder, for the build. */

#include <exception>
#include <filesystem>
#include <iostream>

#include "command_definitions.h"
#include "fusion_base/files.h"
#include "manuals/manuals.h"

int main(int argc, char** argv) {
  using namespace map_fusion;
  if (argc != 2) {
    std::cerr << "usage: write-manuals FOLDER\n";
    return kUsage;
  }
  try {
    Arguments args;
    CLI::App app;
    defineCommands(app, args);
    const std::filesystem::path folder = argv[1], pages = folder / "man1";
    std::filesystem::create_directories(pages);
    const auto write = [](const std::filesystem::path& path, const std::string& text) {
      mrpt::fusion::writeFileAtomically(path.string(), text);
    };
    write(pages / "map-fusion.1", manualPage(app));
    for (const CLI::App* command : commandsOf(app))
      write(pages / ("map-fusion-" + command->get_name() + ".1"), manualPage(app, *command));
    write(folder / "map-fusion", bashCompletion(app));
    return kDone;
  } catch (const std::exception& e) {
    std::cerr << "write-manuals: " << e.what() << "\n";
    return kFailure;
  }
}
