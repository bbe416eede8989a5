// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of parameters in settings files. */
#include "fusion_base/parameter.h"

#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>

#include <cmath>
#include <cstddef>
#include <exception>
#include <stdexcept>
#include <string>

#include "fusion_base/error_text.h"

namespace mrpt::fusion::test::parameter_test {
namespace {

using mrpt::config::CConfigFileMemory;

enum class Colour { Red, Green };

/** A stage with a parameter of each kind. */
struct Stage {
  double length = 0.5;
  double turn = M_PI / 6;
  unsigned tries = 3;
  size_t voxels = 7;
  Colour colour = Colour::Green;

  /** The list of names ends before the parameters do. */
  Parameters parameters() {
    const Names<Colour> names = {{Colour::Red, "red"}, {Colour::Green, "green"}};
    return {number("length", length, 0, 2, "Length, m"),
            advanced(angle("turn_deg", turn, -90, 90, "Turn, deg")),
            count("tries", tries, 1, 5, "Number of tries"),
            count("voxels", voxels, 0, kUnlimited, "Number of voxels"),
            choice("colour", colour, names, "One of " + listOf(names))};
  }
  void load(const std::string& lines) {
    loadParameters(parameters(), CConfigFileMemory("[stage]\n" + lines + "\n"), "stage");
  }
  std::string saved() {
    CConfigFileMemory file;
    saveParameters(parameters(), file, "stage");
    return file.getContent();
  }
  const Parameter& parameter(const std::string& key) {
    all = parameters();
    for (const Parameter& p : all)
      if (p.key == key) return p;
    throw std::out_of_range(key);
  }
  Parameters all;
};

/** What the exception of loading some lines says; empty if there is none. */
std::string errorOfLoading(const std::string& lines) {
  Stage stage;
  try {
    stage.load(lines);
  } catch (const std::exception& e) {
    return messageOf(e);
  }
  return {};
}

TEST(Parameters, ComeBackFromTheFileTheyAreSavedTo) {
  Stage saved;
  saved.length = 1.25;
  saved.turn = -M_PI / 4;
  saved.tries = 5;
  saved.voxels = 123456789;
  saved.colour = Colour::Red;
  Stage loaded;
  loadParameters(loaded.parameters(), CConfigFileMemory(saved.saved()), "stage");
  EXPECT_EQ(loaded.length, 1.25);
  EXPECT_NEAR(loaded.turn, -M_PI / 4, 1e-12);
  EXPECT_EQ(loaded.tries, 5U);
  EXPECT_EQ(loaded.voxels, 123456789U) << "whole numbers keep all digits";
  EXPECT_EQ(loaded.colour, Colour::Red);
}

TEST(Parameters, KeepTheirValuesIfTheirKeysAreMissing) {
  Stage stage;
  stage.load("tries = 4");
  EXPECT_EQ(stage.tries, 4U);
  EXPECT_EQ(stage.length, 0.5);
  EXPECT_EQ(stage.turn, M_PI / 6);
  EXPECT_EQ(stage.voxels, 7U);
  EXPECT_EQ(stage.colour, Colour::Green);
}

TEST(Parameters, AnglesAreDegreesInFilesAndRadiansInFields) {
  Stage stage;
  stage.load("turn_deg = 90");
  EXPECT_DOUBLE_EQ(stage.turn, M_PI / 2);
  EXPECT_EQ(stage.parameter("turn_deg").text(), "90");
  EXPECT_DOUBLE_EQ(stage.parameter("turn_deg").value(), M_PI / 2) << "the value in the field";
  stage.turn = 80 * M_PI / 180;
  EXPECT_EQ(stage.parameter("turn_deg").text(), "80") << "not 79.99999999999999";
}

TEST(Parameters, RangesIncludeTheirEnds) {
  Stage stage;
  for (const char* line : {"length = 0", "length = 2", "turn_deg = -90", "turn_deg = 90",
                           "tries = 1", "tries = 5", "voxels = 0", "voxels = 1e9"})
    EXPECT_NO_THROW(stage.load(line)) << line;
}

TEST(Parameters, AreRefusedOutOfRangeAndStayAsTheyWere) {
  for (const char* line : {"length = -0.01", "length = 2.01", "length = much", "turn_deg = 91",
                           "turn_deg = -91", "tries = 0", "tries = 6", "tries = 2.5", "voxels = -1",
                           "voxels = 1.5", "colour = blue", "colour ="}) {
    Stage stage;
    EXPECT_THROW(stage.load(line), std::exception) << line;
    EXPECT_EQ(stage.saved(), Stage().saved()) << line;
  }
}

TEST(Parameters, ErrorsNameSectionKeyValueAndRange) {
  EXPECT_EQ(errorOfLoading("length = 3"), "[stage] length = 3 is not a number in [0, 2]");
  EXPECT_EQ(errorOfLoading("turn_deg = 91"), "[stage] turn_deg = 91 is not a number in [-90, 90]");
  EXPECT_EQ(errorOfLoading("tries = 2.5"), "[stage] tries = 2.5 is not a whole number in [1, 5]");
  EXPECT_EQ(errorOfLoading("colour = blue"), "[stage] colour = blue is none of red, green");
}

TEST(Parameters, AnUnknownKeyIsNamedAndNothingIsLoaded) {
  EXPECT_EQ(errorOfLoading("lenght = 1"),
            "[stage] has an unknown key 'lenght'; the nearest is 'length'");
  Stage stage;
  EXPECT_THROW(stage.load("length = 1\nlenght = 1"), std::exception);
  EXPECT_EQ(stage.length, 0.5);
}

TEST(Parameters, OtherSectionsAreNotTheirBusiness) {
  Stage stage;
  loadParameters(stage.parameters(),
                 CConfigFileMemory("[other]\nlength = 1\nunknown = 2\n[stage]\nlength = 1.5\n"),
                 "stage");
  EXPECT_EQ(stage.length, 1.5);
}

TEST(Parameters, KeysAreFoundWhateverTheirCase) {
  Stage stage;
  stage.load("LENGTH = 1.5\nTurn_Deg = 45");
  EXPECT_EQ(stage.length, 1.5);
  EXPECT_DOUBLE_EQ(stage.turn, M_PI / 4);
}

TEST(Parameters, HaveTheNamesOfEnumerations) {
  Stage stage;
  stage.load("colour = red");
  EXPECT_EQ(stage.colour, Colour::Red);
  EXPECT_EQ(stage.parameter("colour").text(), "red");
  EXPECT_EQ(stage.parameter("colour").value(), 0) << "its index";
  stage.load("colour = green");
  EXPECT_EQ(stage.colour, Colour::Green);
  EXPECT_EQ(stage.parameter("colour").text(), "green");
  EXPECT_EQ(stage.parameter("colour").value(), 1);
}

TEST(Parameters, ListTheNamesOfAnEnumeration) {
  EXPECT_EQ(listOf(Names<int>{{1, "one"}, {2, "two"}, {3, "three"}}), "one, two, three");
  EXPECT_EQ(listOf(Names<int>{}), "");
}

TEST(Parameters, AreSavedInTheirOrderEachWithItsComment) {
  const std::string file = Stage().saved();
  size_t from = 0;
  for (const char* text :
       {"length", "Length, m", "turn_deg", "Advanced. Turn, deg", "tries", "Number of tries",
        "voxels", "Number of voxels", "colour", "One of red, green"}) {
    from = file.find(text, from);
    ASSERT_NE(from, std::string::npos) << text << " in\n" << file;
  }
}

TEST(Parameters, OnlyThoseMarkedAreAdvanced) {
  Stage stage;
  for (const Parameter& p : stage.parameters())
    EXPECT_EQ(p.is_advanced, p.key == "turn_deg") << p.key;
  const std::string file = stage.saved();
  EXPECT_EQ(file.find("Advanced."), file.rfind("Advanced.")) << file;
}

TEST(Parameters, MultiplyingLengthsKeepsAllOtherValues) {
  double metres = 2, share = 0.5, turn = 1;
  unsigned tries = 3;
  const Parameters list = {length("metres", metres, 0, 10, ""), number("share", share, 0, 1, ""),
                           angle("turn_deg", turn, 0, 180, ""), count("tries", tries, 0, 9, "")};
  multiplyLengths(list, 2.5);
  EXPECT_EQ(metres, 5);
  EXPECT_EQ(share, 0.5);
  EXPECT_EQ(turn, 1);
  EXPECT_EQ(tries, 3U);
}

}  // namespace
}  // namespace mrpt::fusion::test::parameter_test
