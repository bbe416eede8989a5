// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of text that is safe for a terminal. */
#include "fusion_base/printable.h"

#include <gtest/gtest.h>

using mrpt::fusion::printable;

TEST(Printable, KeepsTextOfAnyLanguage) {
  for (const std::string text : {"", "a map.ot", "m\u00fcnchen", "\u5730\u56f3", "\U0001F916"})
    EXPECT_EQ(text, printable(text));
}

TEST(Printable, EscapesWhatATerminalObeys) {
  EXPECT_EQ("a\\x1b[2J\\x0a\\x7f", printable("a\x1b[2J\n\x7f"));
  EXPECT_EQ("\\xc2\\x9b5n", printable("\xc2\x9b"
                                      "5n"))
      << "U+009B is CSI";
  EXPECT_EQ("\\x00", printable(std::string_view("\0", 1)));
}

TEST(Printable, EscapesBytesThatAreNotUtf8) {
  EXPECT_EQ("caf\\xe9", printable("caf\xe9"));
  EXPECT_EQ("\\xc3", printable("\xc3")) << "cut";
  EXPECT_EQ("\\xc0\\x8a", printable("\xc0\x8a")) << "a line feed in two bytes";
  EXPECT_EQ("\\xe0\\x80\\x8a", printable("\xe0\x80\x8a")) << "a line feed in three bytes";
  EXPECT_EQ("\\xff\\xfe", printable("\xff\xfe"));
}

TEST(Printable, CutsLongText) {
  EXPECT_EQ("abc", printable("abc", 3));
  EXPECT_EQ("ab...", printable("abc", 2));
  EXPECT_EQ("\u00fc...", printable("\u00fc\u00fc", 1)) << "between characters";
}
