// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Tests of errors on one line. */
#include "fusion_base/error_text.h"

#include <gtest/gtest.h>
#include <mrpt/core/exceptions.h>

#include <memory>
#include <new>
#include <stdexcept>
#include <string>

namespace mrpt::fusion::test::error_text_test {
namespace {

std::string messageOfText(const std::string& text) { return messageOf(std::runtime_error(text)); }

template <class F>
std::string errorOf(F&& f) {
  try {
    f();
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return {};
}

TEST(MessageOf, IsTheFirstLineOfAPlainException) {
  EXPECT_EQ(messageOfText("no such file"), "no such file");
  EXPECT_EQ(messageOfText("no such file\nand more"), "no such file");
}

TEST(MessageOf, IsNeverEmpty) {
  for (const char* text : {"", "\n", "   ", "Message:   ", "Message:\nMessage:\nLocation: x"})
    EXPECT_EQ(messageOfText(text), "unknown error") << text;
  EXPECT_EQ(messageOfText("Message: the reason\nMessage:\n"), "the reason");
  EXPECT_EQ(messageOf(std::bad_alloc()), "out of memory");
}

TEST(MessageOf, SaysThatMemoryIsOutIfNoThreadCanBeStarted) {
  EXPECT_EQ(messageOfText("pthread_create has failed: Resource temporarily unavailable"),
            "out of memory or of threads");
}

TEST(MessageOf, HoldsNoControlCharacters) {
  EXPECT_EQ(messageOfText("class '\x1b[2J\x9b\x7f\xc2\x85' in m\u00fcnchen.ot"),
            "class '\\x1b[2J\\x9b\\x7f\\xc2\\x85' in m\u00fcnchen.ot");
  EXPECT_LT(messageOfText(std::string(100'000, 'x')).size(), 2000U);
}

TEST(MessageOf, IsWhatWasThrownFirstOfMrptsExceptions) {
  const auto throwsInside = [] {
    MRPT_START
    THROW_EXCEPTION("the reason");
    MRPT_END
  };
  try {
    MRPT_START
    throwsInside();
    MRPT_END
    FAIL();
  } catch (const std::exception& e) {
    ASSERT_NE(std::string(e.what()), "the reason") << "MRPT adds a location";
    EXPECT_EQ(messageOf(e), "the reason");
  }
}

TEST(MessageOf, IsThatOfTheLastLabel) {
  EXPECT_EQ(messageOfText("Message:  caught on the way\nMessage:  thrown first\nLocation: x"),
            "thrown first");
}

TEST(MessageOf, IsTheExceptionThatMrptQuotes) {
  EXPECT_EQ(messageOfText("Message:  Exception while parsing\nOriginal exception:\nthe reason\nx"),
            "the reason");
  EXPECT_EQ(messageOfText("Original exception:\nLocation: x\nMessage:  the reason\n"),
            "the reason");
  EXPECT_EQ(messageOfText("Message: the reason\nOriginal exception:\n\n"), "the reason");
}

TEST(WithPath, ReturnsWhatTheCallReturns) {
  EXPECT_EQ(withPath("a.ot", [] { return 5; }), 5);
  const auto moved = withPath("a.ot", [] { return std::make_unique<int>(6); });
  EXPECT_EQ(*moved, 6);
}

TEST(WithPath, PutsThePathBeforeTheMessage) {
  EXPECT_EQ(errorOf([] { withPath("a.ot", [] { throw std::logic_error("not a map\nx"); }); }),
            "a.ot: not a map");
}

}  // namespace
}  // namespace mrpt::fusion::test::error_text_test
