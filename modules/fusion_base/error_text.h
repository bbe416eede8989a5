// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <typeinfo>

#include "fusion_base/printable.h"

/** \file
 * Error messages of one line. */

namespace mrpt::fusion {

/** Returns the message of an exception, on one line and printable(). Exceptions of MRPT add a
 * location and a call stack to the message, and nest the messages of all functions that rethrow.
 * The innermost message that is not empty is the reason. */
inline std::string messageOf(const std::exception& e) {
  constexpr size_t kMostCharacters = 1000;
  constexpr const char* kLabel = "Message:";
  constexpr size_t kLabelSize = 8;
  // Classes derived from std::bad_alloc have a reason of their own.
  if (typeid(e) == typeid(std::bad_alloc) || typeid(e) == typeid(std::bad_array_new_length))
    return "out of memory";
  const std::string text = e.what();
  // oneTBB's words if there is no memory for the stack of a thread, or if no thread may be added.
  if (text.rfind("pthread_create has failed", 0) == 0) return "out of memory or of threads";
  const auto lineAt = [&](size_t begin) {
    begin = text.find_first_not_of(' ', begin);
    if (begin == std::string::npos) return std::string();
    return printable(text.substr(begin, text.find('\n', begin) - begin), kMostCharacters);
  };
  // MRPT quotes an exception that is not MRPT's after its own message.
  constexpr std::string_view kQuote = "Original exception:\n";
  const size_t quote = text.rfind(kQuote);
  if (quote != std::string::npos && text.find(kLabel, quote) == std::string::npos) {
    std::string line = lineAt(quote + kQuote.size());
    if (!line.empty()) return line;
  }
  for (size_t label = text.rfind(kLabel); label != std::string::npos;
       label = label == 0 ? std::string::npos : text.rfind(kLabel, label - 1)) {
    std::string line = lineAt(label + kLabelSize);
    if (!line.empty()) return line;
  }
  const std::string line = text.find(kLabel) == std::string::npos ? lineAt(0) : std::string();
  return line.empty() ? "unknown error" : line;
}

/** Calls f, and converts its exceptions to std::runtime_error "<path>: <message on one line>". */
template <class F>
auto withPath(const std::string& path, F&& f) {
  try {
    return f();
  } catch (const std::exception& e) {
    throw std::runtime_error(path + ": " + messageOf(e));
  }
}

}  // namespace mrpt::fusion
