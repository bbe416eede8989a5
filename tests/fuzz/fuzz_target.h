// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

/** \file
 * What a fuzz target consists of, and helpers for targets.
 *
 * Each file <name>_fuzzer.cpp is a target and defines the two functions below. The build gives them
 * names of their own in each file: one program replays all targets (replay.cpp), and with
 * MRPT_FUSION_BUILD_FUZZERS each target also becomes a libFuzzer program (libfuzzer_entry.cpp).
 */

/** Runs the target on an input. A crash, undefined behaviour, a hang or more than 2 GB is a fault.
 * \return 0; -1 if the input should not become part of libFuzzer's corpus. */
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

/** Valid inputs to start from. */
std::vector<std::string> fuzzSeeds();

namespace mrpt::fusion::fuzz {

inline std::string_view asText(const uint8_t* data, size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/** Stops the program, as a sanitizer does, if a property does not hold. */
void require(bool holds, const char* property);

/** Calls \a f. An exception that says what is wrong is a right answer to wrong input.
 * \return True if \a f returned. */
bool accepts(const std::function<void()>& f);

/** Takes values from the bytes of an input; zeros after its end. */
class Input {
 public:
  Input(const uint8_t* data, size_t size) : rest_(asText(data, size)) {}

  template <class T>
  T take() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value{};
    const size_t n = std::min(sizeof(T), rest_.size());
    if (n > 0) std::memcpy(&value, rest_.data(), n);
    rest_.remove_prefix(n);
    return value;
  }
  /** A number of two bytes in [-128, 128), or sometimes the eight bytes of any double. */
  double number();
  std::string_view rest() const { return rest_; }
  bool isEmpty() const { return rest_.empty(); }

 private:
  std::string_view rest_;
};

/** The inverse of Input. */
class Output {
 public:
  template <class T>
  Output& put(T value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(value));
    return *this;
  }
  Output& number(double value);
  std::string bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/** A file in memory for readers that take a path. */
class MemoryFile {
 public:
  MemoryFile();
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  /** Replaces the contents. \return The path. */
  const std::string& with(std::string_view bytes);

 private:
  int file_;
  std::string path_;
};

}  // namespace mrpt::fusion::fuzz
