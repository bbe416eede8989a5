// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads whole files, and writes files atomically. */
#include "fusion_base/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace mrpt::fusion {
namespace {

std::string systemError(const std::string& what) { return what + ": " + std::strerror(errno); }

}  // namespace

std::string readFileBytes(const std::string& path) {
  struct stat st {};
  if (::stat(path.c_str(), &st) != 0) throw std::runtime_error(systemError("cannot be opened"));
  if (S_ISDIR(st.st_mode)) throw std::runtime_error("is a directory, not a file");
  std::ifstream f(path, std::ios::binary);
  if (!f) throw std::runtime_error(systemError("cannot be opened"));
  std::string bytes;
  bytes.reserve(static_cast<size_t>(st.st_size));  // 0 for a pipe
  std::array<char, 1U << 16U> block;
  while (f.read(block.data(), block.size()), f.gcount() > 0)
    bytes.append(block.data(), static_cast<size_t>(f.gcount()));
  if (f.bad()) throw std::runtime_error(systemError("cannot be read"));
  if (bytes.empty()) throw std::runtime_error("is empty");
  return bytes;
}

std::string beginningOf(const std::string& path) {
  struct stat st {};
  if (::stat(path.c_str(), &st) == 0 && !S_ISREG(st.st_mode) && !S_ISDIR(st.st_mode))
    throw std::runtime_error("is a pipe or a device: a map is read from a file");
  std::ifstream f(path, std::ios::binary);
  std::string bytes(64, '\0');
  f.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<size_t>(f.gcount()));
  if (bytes.empty()) readFileBytes(path);  // throws the reason: missing, a directory, empty
  return bytes;
}

void writeFileAtomically(const std::string& path, std::string_view bytes) {
  writeFileAtomically(path, [&](const ByteSink& sink) { sink(bytes); });
}

void writeFileAtomically(const std::string& path,
                         const std::function<void(const ByteSink&)>& write) {
  // The existing target of a link is replaced, not the link. Devices, pipes and targets without a
  // name (such as a pipe behind /dev/stdout) are written in place: they have no contents to
  // protect, and a rename would replace them by a file.
  std::error_code nameless;
  const std::string named = std::filesystem::canonical(path, nameless).string();
  const std::string& target = nameless ? path : named;
  struct stat st {};
  const bool in_place = ::stat(path.c_str(), &st) == 0 && (nameless || !S_ISREG(st.st_mode));
  std::string name = in_place ? path : target + ".XXXXXX";
  const int fd = in_place ? ::open(name.c_str(), O_WRONLY) : ::mkstemp(name.data());
  const auto check = [&](bool done) {
    if (!done) throw std::runtime_error(systemError(path + ": cannot be written"));
  };
  check(fd >= 0);
  try {
    write([&](std::string_view bytes) {
      while (!bytes.empty()) {
        const ssize_t n = ::write(fd, bytes.data(), bytes.size());
        check(n >= 0 || errno == EINTR);
        if (n > 0) bytes.remove_prefix(static_cast<size_t>(n));
      }
    });
    if (!in_place) {
      // mkstemp() makes the file private. fchmod() sets the default permissions of a new file.
      const mode_t mask = ::umask(0);
      ::umask(mask);
      check(::fchmod(fd, 0666 & ~mask) == 0 && ::fsync(fd) == 0 &&
            ::rename(name.c_str(), target.c_str()) == 0);
    }
  } catch (...) {
    ::close(fd);
    if (!in_place) ::unlink(name.c_str());
    throw;
  }
  ::close(fd);
}

}  // namespace mrpt::fusion
