// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/config/CLoadableOptions.h>
#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/merging.h>

#include <string>

#include "fusion_core/pair/matching.h"

namespace mrpt::fusion {

/** All parameters of all steps; the defaults are those of share/mrpt_fusion/config_files/pmm.ini.
 * In .ini files angles end in `_deg`. */
struct Options : public mrpt::config::CLoadableOptions {
  MatchParams match;            ///< of edges and of matching
  EvaluationParams evaluation;  ///< of the verdict
  MergeParams merge;            ///< of merging

  /** Missing keys keep their values. \exception std::exception On a value out of range, or a key
   * in the section that is none of these (a misspelt one would else be ignored). */
  void loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                          const std::string& section) override;
  /** Saves all keys, each with a comment and its unit. */
  void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                        const std::string& section) const override;
};

}  // namespace mrpt::fusion
