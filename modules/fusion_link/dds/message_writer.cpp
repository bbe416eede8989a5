// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Sends messages to one robot over DDS. */
#include "fusion_link/dds/message_writer.h"

#include <algorithm>

#include "fusion_link/dds/dds_tools.h"
#include "map_message.h"

namespace mrpt::fusion {
namespace {

/** Longest time for which the first message is waited for. */
constexpr dds_duration_t kMostWaiting = DDS_SECS(1);

}  // namespace

MessageWriter::~MessageWriter() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
  dds_delete(writer_);
}

bool MessageWriter::write(const std::string& message) {
  dds_publication_matched_status_t readers{};
  dds_get_publication_matched_status(writer_, &readers);
  if (readers.current_count == 0) return false;
  {
    const std::lock_guard lock(mutex_);
    checked(failure_, "write");
    if (!waiting_.empty()) return false;
    waiting_ = message;
  }
  changed_.notify_all();
  return true;
}

void MessageWriter::flush(std::chrono::steady_clock::time_point end) {
  {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_until(lock, end, [&] { return waiting_.empty(); })) return;
  }
  const std::chrono::nanoseconds left = end - std::chrono::steady_clock::now();
  if (left.count() > 0) dds_wait_for_acks(writer_, left.count());
}

void MessageWriter::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return is_ending_ || !waiting_.empty(); });
    if (is_ending_) return;
    mrpt_fusion_msg_dds__MapMessage_ wire{};
    wire.bytes._length = wire.bytes._maximum = static_cast<uint32_t>(waiting_.size());
    wire.bytes._buffer = reinterpret_cast<uint8_t*>(waiting_.data());
    lock.unlock();  // write() leaves a message alone that waits
    const dds_return_t done = dds_write(writer_, &wire);
    // A reader that was met just now asks for all again that is on its way.
    if (is_first_ && done == DDS_RETCODE_OK) dds_wait_for_acks(writer_, kMostWaiting);
    lock.lock();
    if (done == DDS_RETCODE_TIMEOUT) continue;
    is_first_ = false;
    failure_ = std::min(failure_, done);
    waiting_.clear();
    changed_.notify_all();
  }
}

}  // namespace mrpt::fusion
