// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <stdexcept>
#include <string>

/** \file
 * Error messages of one line. */

namespace mrpt::fusion {

/** Returns the message of an exception, on one line. Exceptions of MRPT add a location and a call
 * stack to the message, and nest the messages of all functions that rethrow. */
inline std::string messageOf(const std::exception& e) {
  const std::string text = e.what();
  constexpr const char* kLabel = "Message:";
  size_t begin = text.rfind(kLabel);  // the innermost exception
  begin = begin == std::string::npos ? 0 : text.find_first_not_of(' ', begin + 8);
  if (begin == std::string::npos) return "unknown error";
  return text.substr(begin, text.find('\n', begin) - begin);
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
