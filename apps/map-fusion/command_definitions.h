// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>

#include "arguments.h"

/** \file
 * The subcommands of the program. */

namespace map_fusion {

/** Defines all commands with their options. \param[out] args Receives the arguments; it must
 * outlive \a app. */
void defineCommands(CLI::App& app, Arguments& args);

}  // namespace map_fusion
