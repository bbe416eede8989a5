// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Helpers for fuzz targets. */

#include "fuzz_target.h"

#include <mrpt/core/aligned_allocator.h>
#include <mrpt/core/backtrace.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <stdexcept>

/** Stands in for MRPT's function. Each exception of MRPT takes a backtrace with the names of all
 * functions, which takes longer than most readers need to find out what is wrong. */
void mrpt::callStackBackTrace(TCallStackBackTrace&, unsigned, unsigned) noexcept {}

namespace {

constexpr size_t kMostAllocated = size_t{512} << 20U;

/** An allocation in which a small input cannot need as much fails, as it would with little memory
 * left: MRPT's readers of texts and arrays take their size from the file before they look whether
 * the file is as long. */
void* allocate(size_t bytes) noexcept {
  return bytes > kMostAllocated ? nullptr : std::malloc(std::max<size_t>(bytes, 1));
}

void* allocateOrThrow(size_t bytes) {
  void* memory = allocate(bytes);
  if (!memory) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(size_t bytes) { return allocateOrThrow(bytes); }
void* operator new[](size_t bytes) { return allocateOrThrow(bytes); }
void* operator new(size_t bytes, const std::nothrow_t&) noexcept { return allocate(bytes); }
void* operator new[](size_t bytes, const std::nothrow_t&) noexcept { return allocate(bytes); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, size_t) noexcept { std::free(memory); }

/** Stands in for MRPT's function, which returns null to callers that do not check. */
void* mrpt::aligned_malloc(size_t bytes, size_t alignment) {
  void* memory =
      bytes > kMostAllocated
          ? nullptr
          : std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  if (!memory && bytes > 0) throw std::bad_alloc();
  return memory;
}

namespace mrpt::fusion::fuzz {

void require(bool holds, const char* property) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", property);
  std::abort();
}

bool accepts(const std::function<void()>& f) {
  try {
    f();
    return true;
  } catch (const std::exception& e) {
    require(*e.what() != '\0', "an exception has a message");
    return false;
  }
}

namespace {
constexpr uint8_t kAnyDouble = 0xf0;  // from here on the first byte announces eight others
}

double Input::number() {
  if (take<uint8_t>() >= kAnyDouble) return take<double>();
  return take<int16_t>() / 256.0;
}

Output& Output::number(double value) {
  if (std::abs(value) < 128 && std::trunc(value * 256) == value * 256)
    return put(uint8_t{0}).put(static_cast<int16_t>(value * 256));
  return put(kAnyDouble).put(value);
}

MemoryFile::MemoryFile()
    : file_(::memfd_create("fuzz", MFD_CLOEXEC)), path_("/proc/self/fd/" + std::to_string(file_)) {
  if (file_ < 0) throw std::runtime_error("no memory for a file");
}

MemoryFile::~MemoryFile() { ::close(file_); }

const std::string& MemoryFile::with(std::string_view bytes) {
  require(::ftruncate(file_, 0) == 0 &&
              ::pwrite(file_, bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()),
          "a file in memory can be written");
  return path_;
}

}  // namespace mrpt::fusion::fuzz
