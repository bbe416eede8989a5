// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of the options that are composed of the parameters of all stages. */
#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/fusion/options.h>

#include <cstddef>
#include <exception>
#include <set>
#include <string>

#include "fusion_base/error_text.h"
#include "fusion_core/features/parameters.h"
#include "fusion_core/merge/parameters.h"
#include "fusion_core/registration/parameters.h"
#include "fusion_core/search/parameters.h"
#include "fusion_core/verdict/parameters.h"

namespace mrpt::fusion::test::options_test {
namespace {

using mrpt::config::CConfigFileMemory;

/** All that options hold, as text. */
std::string textOf(const Options& options) {
  CConfigFileMemory file;
  options.saveToConfigFile(file, "pmm");
  saveVerdictModel(options.evaluation.model, file);
  return file.getContent();
}

void load(Options& options, const std::string& file) {
  options.loadFromConfigFile(CConfigFileMemory(file), "pmm");
}

std::string errorOfLoading(const std::string& file) {
  Options options;
  try {
    load(options, file);
  } catch (const std::exception& e) {
    return messageOf(e);
  }
  return {};
}

TEST(Options, TakeTheVerdictsModelFromASectionOfTheSameFile) {
  Options options;
  load(options, "[pmm]\nkappa = 0.4\n[VerdictModel]\nversion = 7\nconstant = -3.5\n");
  EXPECT_EQ(options.features.edges.kappa, 0.4);
  EXPECT_EQ(options.evaluation.model.version, 7U);
  EXPECT_EQ(options.evaluation.model.constant, -3.5);
  EXPECT_EQ(options.evaluation.model.log_overlap, VerdictModel().log_overlap) << "a missing key";
}

TEST(Options, KeepTheVerdictsModelIfTheFileHasNone) {
  Options options;
  options.evaluation.model.constant = -3.5;
  load(options, "[pmm]\nkappa = 0.4\n");
  EXPECT_EQ(options.evaluation.model.constant, -3.5);
}

TEST(Options, TakeAModelWithoutOtherParameters) {
  Options options;
  load(options, "[VerdictModel]\nrunner_up = -2\n");
  EXPECT_EQ(options.evaluation.model.runner_up, -2);
}

TEST(Options, ABadValueInEitherSectionChangesNothing) {
  for (const char* file : {"[pmm]\nkappa = 2\n[VerdictModel]\nconstant = -3\n",
                           "[pmm]\nkappa = 0.4\n[VerdictModel]\nconstant = much\n",
                           "[pmm]\nkappa = 0.4\n[VerdictModel]\nversion = 0\n",
                           "[pmm]\nkappa = 0.4\n[VerdictModel]\nconstnat = -3\n",
                           "[pmm]\nkapa = 0.4\n[VerdictModel]\nconstant = -3\n",
                           "[pmm]\nkappa = 0.4\nconstant = -3\n"}) {
    Options options;
    options.features.edges.kappa = 0.3;
    options.evaluation.model.constant = -1;
    const std::string before = textOf(options);
    EXPECT_THROW(load(options, file), std::exception) << file;
    EXPECT_EQ(textOf(options), before) << file;
  }
}

TEST(Options, ErrorsNameTheSectionOfTheKey) {
  EXPECT_EQ(errorOfLoading("[pmm]\nkappa = 2\n"), "[pmm] kappa = 2 is not a number in [0, 1]");
  EXPECT_EQ(errorOfLoading("[VerdictModel]\nkappa = 0.5\n"),
            "[VerdictModel] has an unknown key 'kappa'");
}

TEST(Options, AreSavedWithoutTheVerdictsModel) {
  CConfigFileMemory file;
  Options().saveToConfigFile(file, "pmm");
  EXPECT_TRUE(file.sectionExists("pmm"));
  EXPECT_FALSE(file.sectionExists(kVerdictModelSection));
  EXPECT_FALSE(file.keyExists("pmm", "log_overlap"));
}

TEST(Options, TheVerdictsModelComesBackFromTheFileItIsSavedTo) {
  VerdictModel saved;
  saved.version = 3;
  saved.constant = -1.5;
  saved.log_overlap = 2.5;
  saved.conflict_ratio = -3.5;
  saved.runner_up = -4.5;
  saved.inlier_ratio = 5.5;
  saved.min_overlap = 0.25;
  CConfigFileMemory file;
  saveVerdictModel(saved, file);
  Options options;
  load(options, file.getContent());
  const VerdictModel& loaded = options.evaluation.model;
  EXPECT_EQ(loaded.version, saved.version);
  EXPECT_EQ(loaded.constant, saved.constant);
  EXPECT_EQ(loaded.log_overlap, saved.log_overlap);
  EXPECT_EQ(loaded.conflict_ratio, saved.conflict_ratio);
  EXPECT_EQ(loaded.runner_up, saved.runner_up);
  EXPECT_EQ(loaded.inlier_ratio, saved.inlier_ratio);
  EXPECT_EQ(loaded.min_overlap, saved.min_overlap);
}

TEST(Options, NoTwoStagesShareAKey) {
  Options o;
  std::set<std::string> keys;
  size_t parameters = 0;
  for (const Parameters& stage :
       {parametersOf(o.features), parametersOf(o.search), parametersOf(o.registration),
        parametersOf(o.ranking), parametersOf(o.evaluation), parametersOf(o.merge)})
    for (const Parameter& p : stage) {
      parameters++;
      EXPECT_TRUE(keys.insert(p.key).second) << p.key;
    }
  EXPECT_GT(parameters, 50U);
}

TEST(Options, CommentsSayDegreesWhereKeysDo) {
  Options o;
  for (const Parameters& stage :
       {parametersOf(o.features), parametersOf(o.search), parametersOf(o.registration),
        parametersOf(o.ranking), parametersOf(o.evaluation), parametersOf(o.merge)})
    for (const Parameter& p : stage) {
      const bool is_angle = p.key.size() > 4 && p.key.substr(p.key.size() - 4) == "_deg";
      const bool says_so = p.comment.find(", deg") != std::string::npos;
      EXPECT_EQ(says_so, is_angle) << p.key << ": " << p.comment;
      EXPECT_EQ(p.comment.find('\n'), std::string::npos) << p.key;
    }
}

}  // namespace
}  // namespace mrpt::fusion::test::options_test
