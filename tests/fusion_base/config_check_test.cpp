// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of reading settings so that nothing in them is ignored. */
#include "fusion_base/config_check.h"

#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>

#include <exception>
#include <string>

#include "fusion_base/error_text.h"

namespace mrpt::fusion::test::config_check_test {
namespace {

using mrpt::config::CConfigFileMemory;

CConfigFileMemory fileOf(const std::string& lines) {
  return CConfigFileMemory("[s]\n" + lines + "\n");
}

/** What a call's exception says, on one line; empty if there is none. */
template <class F>
std::string errorOf(F&& f) {
  try {
    f();
  } catch (const std::exception& e) {
    return messageOf(e);
  }
  return {};
}

TEST(CheckKeys, PassesKnownKeysWhateverTheirCase) {
  EXPECT_NO_THROW(checkKeys(fileOf("first = 1\nSECOND = 2"), "s", {"First", "second", "third"}));
}

TEST(CheckKeys, NamesTheUnknownKey) {
  EXPECT_EQ(errorOf([] { checkKeys(fileOf("first = 1\nfrist = 2"), "s", {"first"}); }),
            "[s] has an unknown key 'frist'; the nearest is 'first'");
  EXPECT_EQ(errorOf([] { checkKeys(fileOf("colour = 2"), "s", {"first"}); }),
            "[s] has an unknown key 'colour'");
  const std::string message =
      errorOf([] { checkKeys(fileOf(std::string(200, 'x') + " = 2"), "s", {"first"}); });
  EXPECT_EQ(message.find("the nearest"), std::string::npos) << message;
  EXPECT_NE(errorOf([] { checkKeys(fileOf("first = 1"), "s", {}); }), "");
}

TEST(CheckKeys, PassesASectionThatIsMissing) {
  EXPECT_NO_THROW(checkKeys(fileOf("first = 1"), "another", {}));
}

double read(const std::string& text, NumberKind kind = NumberKind::Real) {
  return readNumber(fileOf("k = " + text), "s", "k", 7, -1, 10, kind);
}

TEST(ReadNumber, OfAMissingKeyIsTheValueGiven) {
  EXPECT_EQ(readNumber(fileOf("other = 1"), "s", "k", 7, 0, 1), 7) << "even out of range";
  EXPECT_EQ(readNumber(fileOf("k = 1"), "another", "k", 7, 0, 1), 7);
}

TEST(ReadNumber, ReadsAllWaysToWriteANumber) {
  EXPECT_EQ(read("2.5"), 2.5);
  EXPECT_EQ(read("  2.5  "), 2.5);
  EXPECT_EQ(read("25e-1"), 2.5);
  EXPECT_EQ(read("+3"), 3);
  EXPECT_EQ(read("2.5 // a comment"), 2.5);
}

TEST(ReadNumber, RangeIncludesItsEndsAndNothingBeyond) {
  EXPECT_EQ(read("-1"), -1);
  EXPECT_EQ(read("10"), 10);
  for (const char* text : {"-1.001", "10.001", "1e300", "1e999", "-1e999"})
    EXPECT_THROW(read(text), std::exception) << text;
}

TEST(ReadNumber, RefusesTextThatIsNoNumber) {
  for (const char* text : {"", "much", "0.5 m", "0.5m", "1 2", "nan", "inf", "1,5"})
    EXPECT_THROW(read(text), std::exception) << text;
}

TEST(ReadNumber, RefusesFractionsOfWholeNumbers) {
  EXPECT_EQ(read("3", NumberKind::Whole), 3);
  EXPECT_EQ(read("3.0", NumberKind::Whole), 3);
  EXPECT_EQ(read("1e1", NumberKind::Whole), 10);
  EXPECT_THROW(read("2.5", NumberKind::Whole), std::exception);
}

TEST(ReadNumber, SaysWhatTheNumberMayBe) {
  EXPECT_EQ(errorOf([] { read("11"); }), "[s] k = 11 is not a number in [-1, 10]");
  EXPECT_EQ(errorOf([] { read("2.5", NumberKind::Whole); }),
            "[s] k = 2.5 is not a whole number in [-1, 10]");
}

TEST(ReadFlag, KnowsFourWordsForEachWhateverTheirCase) {
  for (const char* text : {"true", "yes", "on", "1", "TRUE", "Yes"})
    EXPECT_TRUE(readFlag(fileOf(std::string("k = ") + text), "s", "k", false)) << text;
  for (const char* text : {"false", "no", "off", "0", "FALSE", "Off"})
    EXPECT_FALSE(readFlag(fileOf(std::string("k = ") + text), "s", "k", true)) << text;
}

TEST(ReadFlag, OfAMissingKeyIsTheValueGiven) {
  for (const bool value : {true, false})
    EXPECT_EQ(readFlag(fileOf("other = 1"), "s", "k", value), value);
}

TEST(ReadFlag, RefusesOtherWords) {
  for (const char* text : {"", "2", "maybe", "truee", "y"})
    EXPECT_THROW(readFlag(fileOf(std::string("k = ") + text), "s", "k", true), std::exception)
        << text;
  EXPECT_EQ(errorOf([] { readFlag(fileOf("k = maybe"), "s", "k", true); }),
            "[s] k = maybe is neither true nor false");
}

}  // namespace
}  // namespace mrpt::fusion::test::config_check_test
