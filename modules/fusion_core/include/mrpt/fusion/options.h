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
 * The parameters of all stages. */

namespace mrpt::fusion {

/** The parameters of all stages. The defaults are the values in
 * share/mrpt_fusion/config_files/pmm.ini. Keys of angles end in `_deg`. */
struct MRPT_FUSION_API Options : public mrpt::config::CLoadableOptions {
  FeatureParams features;           ///< Preparation of a map
  SearchParams search;              ///< Search for starts
  RegistrationParams registration;  ///< Refinement of a pose
  RankingParams ranking;            ///< Comparison of poses
  EvaluationParams evaluation;      ///< Verdict
  MergeParams merge;                ///< Merge of two maps

  /** Loads the keys of a section, and the verdict model if \a source has a section [VerdictModel].
   * Missing keys keep their values.
   * \exception std::exception If a value is out of range, or a key in these sections is not a
   * parameter (for example a misspelt key). The options then stay as they were. */
  void loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                          const std::string& section) override;
  /** Saves all keys except the verdict model, each with a comment and its unit. */
  void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                        const std::string& section) const override;
};

/** Section of the verdict model in .ini files. */
constexpr const char* kVerdictModelSection = "VerdictModel";
/** Saves the verdict model in the form of verdict_model.ini. */
MRPT_FUSION_API void saveVerdictModel(const VerdictModel& model,
                                      mrpt::config::CConfigFileBase& target);

}  // namespace mrpt::fusion
