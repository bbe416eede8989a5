// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Parses and checks the command line. */

#include "arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "command_definitions.h"
#include "fusion_base/printable.h"
#include "fusion_base/spelling.h"
#include "output.h"
#include "slice_out.h"

namespace fs = std::filesystem;

namespace map_fusion {

namespace {

/** \exception CLI::ValidationError If the first word of the arguments is not a command. It names
 * the nearest command. */
void checkCommand(const CLI::App& app, int argc, char** argv) {
  const std::string word = argc > 1 ? argv[1] : "-";
  if (word[0] == '-') return;
  std::vector<std::string> commands;
  for (const auto* command : app.get_subcommands({})) commands.push_back(command->get_name());
  const std::string nearest = mrpt::fusion::nearestTo(word, commands).first;
  if (nearest == word) return;
  std::error_code none;
  if (fs::exists(word, none))
    throw CLI::ValidationError("'" + mrpt::fusion::printable(word) +
                               "' is a file; a command comes first: map-fusion fuse A B -o FILE");
  throw CLI::ValidationError("there is no command '" +
                             mrpt::fusion::printable(word, mrpt::fusion::kMostLetters) +
                             "'; the nearest is '" + nearest + "'");
}

/** Returns what to do instead of giving a command an output map that it does not write. */
std::string insteadOfOutput(const CLI::App& command) {
  const std::string name = command.get_name();
  return name + " has no option -o: it writes no map" +
         (command.get_option_no_throw("--pose-out") ? "; --pose-out writes the pose" : "") +
         (command.get_option_no_throw("--picture") ? "; fuse and merge write maps" : "");
}

/** \exception CLI::ValidationError If the numbers of a point are several words. */
void checkPoint(const std::vector<std::string>& words, size_t option) {
  double ignored = 0;
  if (words[option] == "--sensor-origin" && words.size() > option + 2 &&
      CLI::detail::lexical_cast(words[option + 1], ignored) &&
      CLI::detail::lexical_cast(words[option + 2], ignored))
    throw CLI::ValidationError("--sensor-origin: three numbers need quotes: \"0 0 0\"");
}

/** \exception CLI::ValidationError If an option does not exist. It names the nearest option. */
void checkOptions(const CLI::App& app, int argc, char** argv) {
  constexpr size_t kMostChanges = 3;
  const auto commands = app.get_subcommands({});
  const auto found = std::find_if(commands.begin(), commands.end(), [&](const CLI::App* c) {
    return argc > 1 && c->get_name() == argv[1];
  });
  if (found == commands.end()) return;
  const CLI::App* command = *found;
  std::vector<std::string> options;
  for (const auto* option : command->get_options())
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  for (int i = 2; i < argc; i++) {
    const std::string word = argv[i], name = word.substr(0, word.find('='));
    if (word == "--") return;
    checkPoint({argv, argv + argc}, static_cast<size_t>(i));
    if ((word == "-o" || name == "--output") && !command->get_option_no_throw("--output"))
      throw CLI::ValidationError(insteadOfOutput(*command));
    if (word.substr(0, 2) != "--" || command->get_option_no_throw(name)) continue;
    const auto [nearest, changes] = mrpt::fusion::nearestTo(name, options);
    throw CLI::ValidationError(command->get_name() + " has no option " +
                               mrpt::fusion::printable(name, mrpt::fusion::kMostLetters) +
                               (changes > kMostChanges ? "" : "; the nearest is " + nearest));
  }
}

/** \exception CLI::ValidationError If the second of two numbers is below the first. */
void checkRange(const std::vector<double>& numbers, const std::string& option) {
  if (numbers.size() == 2 && numbers[1] < numbers[0])
    throw CLI::ValidationError(option + ": the second number is below the first");
}

/** \exception CLI::ValidationError If two outputs are the same file. */
void checkOutputs(const Arguments& args) {
  const auto outputs = outputsOf(args);
  for (size_t i = 0; i < outputs.size(); i++)
    for (size_t j = 0; j < i; j++)
      if (isSameOutput(outputs[i], outputs[j]))
        throw CLI::ValidationError(
            "two outputs are the same file: " + mrpt::fusion::printable(outputs[j]) + " and " +
            mrpt::fusion::printable(outputs[i]));
}

/** \exception CLI::ValidationError If the extension of a picture, page or scene, in capitals or
 * not, says that the file is something else. Devices and standard output take all. */
void checkDrawings(const Arguments& args) {
  const auto check = [](const std::string& path, const std::string& what,
                        const std::string& extension) {
    using CLI::detail::to_lower;
    if (path.empty() || isDevice(path)) return;
    if (to_lower(fs::path(path).extension().string()) == to_lower(extension)) return;
    throw CLI::ValidationError(mrpt::fusion::printable(path) + ": " + what + " ends in " +
                               extension);
  };
  check(args.picture, "a picture", ".png");
  check(args.page, "a page", ".html");
  check(args.scene, "a scene", ".3Dscene");
}

/** \exception CLI::ValidationError If the extension of the output is that of files that the command
 * does not write. */
void checkFormat(const Arguments& args) {
  const std::string& output = args.output;
  if (output.empty() || args.command == "slice") return;
  const bool is_other = mapExtensionOf(output) == MapExtension::OfOthers;
  const fs::path extension = fs::path(output).extension();
  const bool is_octree = extension == ".ot" || extension == ".bt";
  const auto refuse = [&](const std::string& formats) {
    throw CLI::ValidationError(mrpt::fusion::printable(output) + ": " + args.command + " writes " +
                               formats);
  };
  if (args.command == "pack") {
    if (is_octree) refuse("a mission, not an octree: .rawlog");
  } else if (args.command == "edges") {
    if (is_octree || (is_other && extension != ".ply"))
      refuse("edges, not an octree: .ply or .gridmap");
  } else if (is_other) {
    const fs::path unpacked = extension == ".gz" ? fs::path(output).stem() : fs::path();
    const bool is_packed_octree = unpacked.extension() == ".ot" || unpacked.extension() == ".bt";
    refuse("maps: .ot or .bt of OctoMap, .gridmap or .gridmap.gz of MRPT" +
           std::string(is_packed_octree ? ". It does not pack octrees: gzip does" : ""));
  }
}

}  // namespace

std::vector<std::string> outputsOf(const Arguments& args) {
  std::vector<std::string> outputs;
  const std::string yaml = args.command == "slice" ? yamlBeside(args.output) : std::string();
  for (const auto& path : {args.output, yaml, args.pose_out, args.poses_out, args.picture,
                           args.scene, args.page, args.json, args.recording})
    if (!path.empty()) outputs.push_back(path);
  return outputs;
}

std::optional<ExitCode> parseArguments(int argc, char** argv, Arguments& args) {
  if (argc > 1 && std::string(argv[1]) == "help") {  // `help COMMAND` is `COMMAND --help`
    std::string help = "--help";
    char* words[] = {argv[0], argc > 2 ? argv[2] : help.data(), help.data()};
    return parseArguments(argc > 2 ? 3 : 2, words, args);
  }
  CLI::App app;
  defineCommands(app, args);
  try {
    checkCommand(app, argc, argv);
    checkOptions(app, argc, argv);
    app.parse(argc, argv);
    args.command = app.get_subcommands().front()->get_name();
    checkFormat(args);
    checkOutputs(args);
    checkDrawings(args);
    checkRange(args.heights, "--heights");
    checkRange(args.thresholds, "--thresholds");
    if (args.maps.size() != 2 && !(args.init + args.pose_out + args.picture + args.scene).empty())
      throw CLI::ValidationError(
          "--init, --pose-out, --picture and --scene need exactly two maps, A and B");
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kDone : kUsage;
  }
  return std::nullopt;
}

}  // namespace map_fusion
