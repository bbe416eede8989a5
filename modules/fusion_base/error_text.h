// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <stdexcept>
#include <string>

namespace mrpt::fusion {

/** What an exception says, on one line: MRPT's own wrap their message in a location and a call
 * stack, and in the messages of those that caught it on the way. */
inline std::string messageOf(const std::exception& e) {
  const std::string text = e.what();
  constexpr const char* kLabel = "Message:";
  size_t begin = text.rfind(kLabel);  // the first to be thrown
  begin = begin == std::string::npos ? 0 : text.find_first_not_of(' ', begin + 8);
  if (begin == std::string::npos) return "unknown error";
  return text.substr(begin, text.find('\n', begin) - begin);
}

/** Calls f; what it throws becomes a std::runtime_error "<path>: <message on one line>". */
template <class F>
auto withPath(const std::string& path, F&& f) {
  try {
    return f();
  } catch (const std::exception& e) {
    throw std::runtime_error(path + ": " + messageOf(e));
  }
}

}  // namespace mrpt::fusion
