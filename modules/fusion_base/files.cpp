// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Reads whole files, and writes files atomically. */
#include "fusion_base/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include "fusion_base/gzip.h"

namespace mrpt::fusion {
namespace {

std::string systemError(const std::string& what) { return what + ": " + std::strerror(errno); }

/** Names of the temporary files that exist. A signal handler reads them, so there is no lock. */
std::array<std::atomic<const char*>, 16> temporary_files{};
/** Number of calls of removeTemporaryFiles() that are running. A name must outlive them. */
std::atomic<int> removing{0};

/** Enters a name in the list of temporary files as long as it lives. If the list is full, a signal
 * leaves the file. */
class TemporaryName {
 public:
  explicit TemporaryName(const std::string& name) : name_(name.c_str()) {
    for (auto& slot : temporary_files) {
      const char* none = nullptr;
      if (slot.compare_exchange_strong(none, name_)) {
        slot_ = &slot;
        return;
      }
    }
  }
  ~TemporaryName() {
    if (!slot_) return;
    slot_->store(nullptr);
    // A signal handler in another thread may hold the name.
    while (removing.load() > 0) std::this_thread::yield();
  }
  TemporaryName(const TemporaryName&) = delete;
  TemporaryName& operator=(const TemporaryName&) = delete;

 private:
  const char* name_;
  std::atomic<const char*>* slot_ = nullptr;
};

/** Returns a name for a temporary file beside a file. No other call returns the same name. */
std::string temporaryNameFor(const std::string& target) {
  static std::atomic<uint64_t> calls{0};
  const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
  // Consecutive numbers, spread over the letters.
  uint64_t number = static_cast<uint64_t>(now) + (static_cast<uint64_t>(::getpid()) << 40U) +
                    (calls.fetch_add(1) << 20U);
  number = (number ^ (number >> 31U)) * 0x9E3779B97F4A7C15U;
  constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyz0123456789";
  std::string name = target + ".";
  for (int i = 0; i < 8; i++) {
    name += kLetters[number % kLetters.size()];
    number /= kLetters.size();
  }
  return name;
}

/** Writes pieces of bytes to an open file. */
class FileWriter {
 public:
  FileWriter(const std::string& path, int fd) : path_(path), fd_(fd) { check(fd >= 0); }

  void check(bool done) const {
    if (!done) throw std::runtime_error(systemError(path_ + ": cannot be written"));
  }
  void write(std::string_view bytes) const {
    while (!bytes.empty()) {
      const ssize_t n = ::write(fd_, bytes.data(), bytes.size());
      check(n >= 0 || errno == EINTR);
      if (n > 0) bytes.remove_prefix(static_cast<size_t>(n));
    }
  }

 private:
  const std::string& path_;
  int fd_;
};

using Pieces = std::function<void(const ByteSink&)>;

void writeInPlace(const std::string& path, int fd, const Pieces& write) {
  const FileWriter file(path, fd);
  const auto close = [fd] {
    if (fd != STDOUT_FILENO) ::close(fd);
  };
  try {
    write([&](std::string_view bytes) { file.write(bytes); });
  } catch (...) {
    close();
    throw;
  }
  close();
}

/** Writes a temporary file, and gives it the name \a target.
 * \param[in] rights Rights of the file that is replaced. Negative: there is none. A new file gets
 * the rights that the system gives it. */
void writeAndRename(const std::string& path, const std::string& target, int rights,
                    const Pieces& write) {
  const std::string name = temporaryNameFor(target);
  const TemporaryName temporary(name);
  const mode_t mode = rights < 0 ? 0666 : static_cast<mode_t>(rights);
  const int fd = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  const FileWriter file(path, fd);
  try {
    write([&](std::string_view bytes) { file.write(bytes); });
    file.check((rights < 0 || ::fchmod(fd, mode) == 0) && ::fsync(fd) == 0 &&
               ::rename(name.c_str(), target.c_str()) == 0);
  } catch (...) {
    ::close(fd);
    ::unlink(name.c_str());
    throw;
  }
  ::close(fd);
}

}  // namespace

std::string readFileBytes(const std::string& path, size_t most) {
  struct stat st {};
  if (::stat(path.c_str(), &st) != 0) throw std::runtime_error(systemError("cannot be opened"));
  if (S_ISDIR(st.st_mode)) throw std::runtime_error("is a directory, not a file");
  std::ifstream f(path, std::ios::binary);
  if (!f) throw std::runtime_error(systemError("cannot be opened"));
  std::string bytes;
  bytes.reserve(std::min(most, static_cast<size_t>(st.st_size)));  // 0 for a pipe
  std::array<char, 1U << 16U> block;
  while (f.read(block.data(), block.size()), f.gcount() > 0) {
    bytes.append(block.data(), static_cast<size_t>(f.gcount()));
    if (bytes.size() > most)
      throw std::runtime_error("has more than " + std::to_string(most) + " bytes: too many");
  }
  if (f.bad()) throw std::runtime_error(systemError("cannot be read"));
  if (bytes.empty()) throw std::runtime_error("is empty");
  return bytes;
}

std::string beginningOf(const std::string& path) {
  struct stat st {};
  if (::stat(path.c_str(), &st) == 0 && !S_ISREG(st.st_mode) && !S_ISDIR(st.st_mode))
    throw std::runtime_error("is a pipe or a device: a map is read from a file");
  constexpr size_t kBeginning = 64;
  constexpr size_t kPackedBeginning =
      4096;  // bytes of gzip data that give at least kBeginning bytes
  std::ifstream f(path, std::ios::binary);
  std::string bytes(kPackedBeginning, '\0');
  f.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<size_t>(f.gcount()));
  if (bytes.empty()) readFileBytes(path);  // throws the reason: missing, a directory, empty
  if (isGzip(bytes)) {
    std::string unpacked = gunzippedBeginning(bytes, kBeginning);
    if (!unpacked.empty()) return unpacked;
  }
  return bytes.substr(0, kBeginning);
}

void writeFileAtomically(const std::string& path, std::string_view bytes) {
  writeFileAtomically(path, [&](const ByteSink& sink) { sink(bytes); });
}

void writeFileAtomically(const std::string& path,
                         const std::function<void(const ByteSink&)>& write) {
  if (path == kStandardOutput) return writeInPlace("standard output", STDOUT_FILENO, write);
  // The existing target of a link is replaced, not the link. Devices, pipes and targets without a
  // name (such as a pipe behind /dev/stdout) are written in place: they have no contents to
  // protect, and a rename would replace them by a file.
  std::error_code nameless;
  const std::string named = std::filesystem::canonical(path, nameless).string();
  struct stat st {};
  const bool exists = ::stat(path.c_str(), &st) == 0;
  if (exists && (nameless || !S_ISREG(st.st_mode)))
    return writeInPlace(path, ::open(path.c_str(), O_WRONLY | O_CLOEXEC), write);
  constexpr mode_t kRights = 0777;
  writeAndRename(path, nameless ? path : named,
                 exists ? static_cast<int>(st.st_mode & kRights) : -1, write);
}

FileAppender::FileAppender(std::string path)
    : path_(std::move(path)),
      fd_(::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666)) {
  FileWriter(path_, fd_);  // throws if the file could not be opened
}
FileAppender::~FileAppender() { ::close(fd_); }

void FileAppender::append(std::string_view bytes) {
  struct stat st {};
  const FileWriter file(path_, fd_);
  file.check(::fstat(fd_, &st) == 0);
  try {
    file.write(bytes);
  } catch (const std::runtime_error&) {
    if (S_ISREG(st.st_mode) && ::ftruncate(fd_, st.st_size) != 0)
      throw std::runtime_error(systemError(path_ + ": ends within an object"));
    throw;
  }
}

void removeTemporaryFiles() noexcept {
  removing.fetch_add(1);
  for (auto& slot : temporary_files)
    if (const char* name = slot.load()) ::unlink(name);
  removing.fetch_sub(1);
}

}  // namespace mrpt::fusion
