// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads lines, words and numbers of text. */

#include "fusion_octree/point_clouds/text_reader.h"

#include <charconv>
#include <string>

#include "fusion_base/byte_reader.h"
#include "fusion_base/printable.h"

namespace mrpt::fusion {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";

std::string quoted(std::string_view word) {
  constexpr size_t kMostCharacters = 20;
  return "'" + printable(word, kMostCharacters) + "'";
}

/** Parses a whole word. \return False if the word is not a number of this type. */
template <class T>
bool parse(std::string_view word, T& value) {
  const char* end = word.data() + word.size();
  const auto result = std::from_chars(word.data(), end, value);
  return result.ec == std::errc() && result.ptr == end;
}

}  // namespace

std::string_view TextReader::takeLine() {
  if (text_.empty()) corrupt("the header is truncated");
  const size_t length = text_.find('\n');
  std::string_view line = text_.substr(0, length);
  text_.remove_prefix(length == std::string_view::npos ? text_.size() : length + 1);
  const size_t first = line.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return line.substr(first, line.find_last_not_of(kBlanks) - first + 1);
}

std::string_view TextReader::nextWord() {
  const size_t first = text_.find_first_not_of(kBlanks);
  text_.remove_prefix(first == std::string_view::npos ? text_.size() : first);
  const std::string_view word = text_.substr(0, text_.find_first_of(kBlanks));
  text_.remove_prefix(word.size());
  return word;
}

std::string_view TextReader::takeWord() {
  const std::string_view word = nextWord();
  if (word.empty()) corrupt("the data is truncated");
  return word;
}

double TextReader::takeNumber() { return numberOf(takeWord()); }

std::vector<std::string_view> wordsOf(std::string_view line) {
  std::vector<std::string_view> words;
  TextReader reader(line);
  for (auto word = reader.nextWord(); !word.empty(); word = reader.nextWord())
    words.push_back(word);
  return words;
}

size_t wholeNumber(std::string_view word, size_t most) {
  size_t value = 0;
  if (!parse(word, value)) corrupt(quoted(word) + " is not a whole number");
  if (value > most) corrupt(quoted(word) + " is more than " + std::to_string(most));
  return value;
}

double numberOf(std::string_view word) {
  std::string_view digits = word;
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
  double value = 0;
  if (!parse(digits, value)) corrupt(quoted(word) + " is not a number");
  return value;
}

}  // namespace mrpt::fusion
