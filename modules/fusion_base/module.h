// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

/** \file
 * Modules: libraries that only some runs need. */

namespace mrpt::fusion {

/** Loads a module and returns a function of it. The module stays loaded. It is searched in the run
 * path, then in the folder mrpt-fusion below the library or program that this code is part of.
 * \param[in] file Name of the file of the module.
 * \param[in] name Name of the function.
 * \param[in] contents What the module holds, for the message.
 * \exception std::runtime_error "<contents>: <reason>" if it cannot be loaded. */
void* functionOfModule(const char* file, const char* name, const std::string& contents);

}  // namespace mrpt::fusion
