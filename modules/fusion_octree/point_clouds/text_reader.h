// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

/** \file
 * Lines, words and numbers of text. */

namespace mrpt::fusion {

/** Reads lines, words and numbers from the front of a text. */
class TextReader {
 public:
  explicit TextReader(std::string_view text) : text_(text) {}

  /** Returns the next line without its end, and without blanks around it.
   * \exception std::runtime_error At the end of the text. */
  std::string_view takeLine();
  /** Returns the next word. Blanks and ends of lines separate words. Empty at the end of the text.
   */
  std::string_view nextWord();
  /** Returns the next word. \exception std::runtime_error At the end of the text. */
  std::string_view takeWord();
  /** Returns the number that comes next. It may be nan or inf. \exception std::runtime_error If it
   * is not a number, or at the end of the text. */
  double takeNumber();

  /** Returns the text that was not read. */
  std::string_view rest() const { return text_; }

 private:
  std::string_view text_;
};

/** Returns the words of a line. */
std::vector<std::string_view> wordsOf(std::string_view line);

/** Returns a whole number of a header. \exception std::runtime_error If the word is not a whole
 * number, is negative, or is above \a most. */
size_t wholeNumber(std::string_view word, size_t most);

/** Returns a number. It may be nan or inf. \exception std::runtime_error If the word is not a
 * number. */
double numberOf(std::string_view word);

}  // namespace mrpt::fusion
