// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

/** \file
 * Manual pages and the completion of bash, made of the definitions that --help prints. */

namespace map_fusion {

/** Returns the commands of the program. */
std::vector<const CLI::App*> commandsOf(const CLI::App& app);

/** Returns the text that stands for the value of an option; empty for a flag. */
std::string valueOf(const CLI::Option& option);

/** Returns the values that an option accepts, if it accepts words of a list. */
std::vector<std::string> wordsOf(const CLI::Option& option);

/** Returns the manual page of the program in the language of troff. */
std::string manualPage(const CLI::App& app);

/** Returns the manual page of a command. */
std::string manualPage(const CLI::App& app, const CLI::App& command);

/** Returns a script that completes commands, options and values in bash. */
std::string bashCompletion(const CLI::App& app);

}  // namespace map_fusion
