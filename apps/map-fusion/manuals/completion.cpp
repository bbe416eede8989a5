// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The completion of bash. */

#include <sstream>

#include "manuals/manuals.h"

namespace map_fusion {
namespace {

/** Returns the names of all options of a command, and of the program. */
std::vector<std::string> namesOf(const CLI::App& command) {
  std::vector<std::string> names;
  for (const auto* option : command.get_options())
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string quoted(const std::vector<std::string>& words) {
  return "'" + CLI::detail::join(words, " ") + "'";
}

/** Returns the case of a command: its options, and the words of those that take words. */
std::string caseOf(const CLI::App& command) {
  std::ostringstream out;
  out << "    " << command.get_name() << ")\n      case $previous in\n";
  for (const auto* option : command.get_options())
    if (const auto words = wordsOf(*option); !words.empty())
      out << "        --" << option->get_lnames().front() << ") words=" << quoted(words) << " ;;\n";
  out << "        *) [[ $current != -* ]] || words=" << quoted(namesOf(command))
      << " ;;\n      esac ;;\n";
  return out.str();
}

}  // namespace

std::string bashCompletion(const CLI::App& app) {
  std::vector<std::string> first = namesOf(app);
  for (const CLI::App* command : commandsOf(app)) first.push_back(command->get_name());
  std::ostringstream out;
  out << "# Completion of map-fusion in bash. Files complete what is neither a command nor an "
         "option.\n"
         "_map_fusion() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} words=\n"
         "  case ${COMP_WORDS[1]} in\n";
  for (const CLI::App* command : commandsOf(app)) out << caseOf(*command);
  out << "  esac\n"
         "  ((COMP_CWORD > 1)) || words="
      << quoted(first)
      << "\n"
         "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n"
         "}\n"
         "complete -o default -F _map_fusion map-fusion\n";
  return out.str();
}

}  // namespace map_fusion
