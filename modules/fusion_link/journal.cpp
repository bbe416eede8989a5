// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Appends samples to a file, and reads them back. */
#include "fusion_link/journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>
#include <zlib.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string_view>

#include "fusion_base/byte_reader.h"
#include "fusion_base/byte_writer.h"
#include "fusion_base/files.h"
#include "fusion_link/statements.h"

namespace mrpt::fusion {
namespace {

/** Largest record: names, numbers and value. */
constexpr size_t kMostRecord = kMostSampleBytes + 2 * kMostNameCharacters + 64;

uint32_t checksumOf(std::string_view bytes) {
  return static_cast<uint32_t>(
      ::crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

std::string recordOf(const Sample& sample) {
  const std::string bytes = toBytes(sample);
  std::string record;
  appendValue(static_cast<uint32_t>(bytes.size()), record);
  appendValue(checksumOf(bytes), record);
  return record + bytes;
}

/** Reads all whole records. \return Number of their bytes. */
size_t readRecords(std::string_view file, const std::function<void(const Sample&)>& on_sample) {
  ByteReader in(file);
  constexpr size_t kHead = 2 * sizeof(uint32_t);
  while (in.size() >= kHead) {
    const size_t before = in.size();
    const auto size = in.take<uint32_t>();
    const auto checksum = in.take<uint32_t>();
    if (size > kMostRecord || size > in.size()) return file.size() - before;
    const std::string_view bytes = in.takeBytes(size);
    if (checksumOf(bytes) != checksum) return file.size() - before;
    try {
      on_sample(sampleOf(bytes));
    } catch (const std::runtime_error&) {  // of another version of the program
    }
  }
  return file.size() - in.size();
}

}  // namespace

Journal::Journal(const std::string& folder, const std::function<void(const Sample&)>& on_sample) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw std::runtime_error(folder + ": " + error.message());
  path_ = (fs::path(folder) / "samples").string();
  const std::string lock = path_ + ".lock";
  lock_ = ::open(lock.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock_ < 0 || ::flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    const int reason = errno;
    if (lock_ >= 0) ::close(lock_);
    throw std::runtime_error(
        folder + ": " +
        (reason == EWOULDBLOCK ? "another process uses this journal" : std::strerror(reason)));
  }
  size_t whole = 0;
  if (fs::file_size(path_, error) > 0 && !error)
    whole = readRecords(readFileBytes(path_), on_sample);
  open();
  if (::ftruncate(file_, static_cast<off_t>(whole)) != 0) fail("cannot be written");
  size_ = whole;
}

Journal::~Journal() {
  if (file_ >= 0) ::close(file_);
  if (lock_ >= 0) ::close(lock_);
}

void Journal::open() {
  if (file_ >= 0) ::close(file_);
  file_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file_ < 0) fail("cannot be opened");
}

void Journal::fail(const char* what) const {
  throw std::runtime_error(path_ + ": " + what + ": " + std::strerror(errno));
}

void Journal::append(const Sample& sample) {
  const std::string record = recordOf(sample);
  for (size_t done = 0; done < record.size();) {
    const ssize_t n = ::write(file_, record.data() + done, record.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail("cannot be written");
    done += static_cast<size_t>(n);
  }
  size_ += record.size();
  is_dirty_ = true;
}

void Journal::sync() {
  if (!is_dirty_) return;
  if (::fdatasync(file_) != 0) fail("cannot be written");
  is_dirty_ = false;
}

bool Journal::isLarge(size_t bytes) const {
  constexpr size_t kSlack = size_t{1} << 20U;
  return size_ > 2 * bytes + kSlack;
}

void Journal::rewrite(const std::vector<Sample>& samples) {
  size_t size = 0;
  writeFileAtomically(path_, [&](const ByteSink& sink) {
    for (const Sample& sample : samples) {
      const std::string record = recordOf(sample);
      sink(record);
      size += record.size();
    }
  });
  open();
  size_ = size;
  is_dirty_ = false;
}

}  // namespace mrpt::fusion
