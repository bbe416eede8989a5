// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/config/CLoadableOptions.h>
#include <mrpt/fusion/evaluation.h>
#include <mrpt/fusion/export.h>
#include <mrpt/fusion/merging.h>
#include <mrpt/fusion/prepared_map.h>
#include <mrpt/fusion/registration_params.h>
#include <mrpt/fusion/search_params.h>

#include <string>

/** \file
 * All parameters in one place. */

namespace mrpt::fusion {

/** The parameters of all stages; the defaults are those of share/mrpt_fusion/config_files/pmm.ini.
 * In .ini files angles end in `_deg`. */
struct MRPT_FUSION_API Options : public mrpt::config::CLoadableOptions {
  FeatureParams features;           ///< Preparing a map
  SearchParams search;              ///< Search for starts
  RegistrationParams registration;  ///< Refining a pose
  RankingParams ranking;            ///< Comparing poses
  EvaluationParams evaluation;      ///< Verdict
  MergeParams merge;                ///< Merging

  /** Loads the keys of a section, and the verdict's model if \a source has a section
   * [VerdictModel]. Missing keys keep their values. \exception std::exception On a value out of
   * range, or a key in either section that is no parameter (a misspelt key would else be ignored).
   * Nothing is changed then. */
  void loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                          const std::string& section) override;
  /** Saves all keys but the verdict's model, each with a comment and its unit. */
  void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                        const std::string& section) const override;
};

/** Section of the verdict's model in .ini files. */
constexpr const char* kVerdictModelSection = "VerdictModel";
/** Saves the verdict's model, as verdict_model.ini has it. */
MRPT_FUSION_API void saveVerdictModel(const VerdictModel& model,
                                      mrpt::config::CConfigFileBase& target);

}  // namespace mrpt::fusion
