// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/config/CConfigFileBase.h>

#include <functional>
#include <string>

namespace mrpt::fusion {

/** How to make a map of recorded observations. */
struct BuildParams {
  /** Map definition as MRPT's apps read it: `<kind>_count` in \a section and the maps' own sections
   * beside it; null: one CProbOctoMap with its default options. Not owned. */
  const mrpt::config::CConfigFileBase* config = nullptr;
  std::string section = "MappingApplication";  ///< of \a config
  /** Called with the number of observations inserted so far, if given. */
  std::function<void(size_t inserted)> progress;
};

}  // namespace mrpt::fusion
