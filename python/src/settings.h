// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/fusion/options.h>
#include <pybind11/pybind11.h>

#include <string>

/** \file
 * Options from Python. */

namespace mrpt_fusion_python {

/** Options, and the text that they were loaded from. Equal texts give equal options. */
struct Settings {
  mrpt::fusion::Options options;
  std::string text;
};

/** Loads options from a dict with the names of pmm.ini, or from the path of such a file.
 * \exception std::exception If a name is unknown or a value is out of range. */
Settings settingsOf(const pybind11::object& options);

/** Writes a dict as a section of an .ini file.
 * \exception pybind11::type_error If the dict holds anything but names, numbers and words. */
std::string iniText(const pybind11::dict& values, const std::string& section);

/** Checks that all keys of a section of settings are keys of the section of the defaults.
 * \exception std::runtime_error If a key is unknown. The message names the nearest key. */
void checkKeys(const mrpt::config::CConfigFileBase& settings,
               const mrpt::config::CConfigFileBase& defaults, const std::string& section);

/** Returns the path that an object of Python stands for: str, bytes or os.PathLike. */
std::string pathOf(const pybind11::object& path);

}  // namespace mrpt_fusion_python
