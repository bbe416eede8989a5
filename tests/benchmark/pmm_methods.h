// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/slam/CProbabilisticMapMatching.h>

#include <memory>
#include <string>

#include "methods.h"

/** \file Our own methods. Apart from methods.h: MRPT's headers do not compile beside PCL's. */

namespace mrpt::fusion::benchmark {

using Settings = mrpt::slam::CProbabilisticMapMatching::TConfigParams;

/** Our own matching and evaluation, with whatever settings. */
std::unique_ptr<Method> makeMatching(const Settings& settings);

/** The settings of share/mrpt_fusion/config_files/pmm_paper.ini. */
Settings publishedSettings();
/** The default, from the guess alone. */
Settings withoutSearch();
/** The published settings, without the voxel level. */
Settings firstLevelSettings();

/** "first_level", "pmm_paper", "no_search" or "default", or one of makePclMethod()'s names.
 * \exception std::invalid_argument For any other name. */
std::unique_ptr<Method> makeMethod(const std::string& name);

}  // namespace mrpt::fusion::benchmark
