// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Combines, loads and saves the parameters of the stages. */
#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/fusion/options.h>

#include <iterator>

#include "fusion_base/parameter.h"
#include "fusion_core/features/parameters.h"
#include "fusion_core/merge/parameters.h"
#include "fusion_core/pair/scaled_options.h"
#include "fusion_core/registration/parameters.h"
#include "fusion_core/search/parameters.h"
#include "fusion_core/verdict/parameters.h"

namespace mrpt::fusion {
namespace {

/** Lists the parameters of all stages, in the order of the pipeline. */
Parameters parametersOf(Options& o) {
  Parameters all;
  for (Parameters of_stage :
       {parametersOf(o.features), parametersOf(o.search), parametersOf(o.registration),
        parametersOf(o.ranking), parametersOf(o.evaluation), parametersOf(o.merge)})
    std::move(of_stage.begin(), of_stage.end(), std::back_inserter(all));
  return all;
}

}  // namespace

Options scaledBy(Options options, double scale) {
  if (scale != 1) multiplyLengths(parametersOf(options), scale);
  return options;
}

void Options::loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                                 const std::string& section) {
  Options loaded(*this);
  loadParameters(parametersOf(loaded), source, section);
  if (source.sectionExists(kVerdictModelSection))
    loadParameters(parametersOf(loaded.evaluation.model), source, kVerdictModelSection);
  *this = loaded;
}

void Options::saveToConfigFile(mrpt::config::CConfigFileBase& target,
                               const std::string& section) const {
  Options copy(*this);
  saveParameters(parametersOf(copy), target, section);
}

void saveVerdictModel(const VerdictModel& model, mrpt::config::CConfigFileBase& target) {
  VerdictModel copy(model);
  saveParameters(parametersOf(copy), target, kVerdictModelSection);
}

}  // namespace mrpt::fusion
