// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <dds/dds.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

/** \file
 * Sends messages to one robot over DDS. */

namespace mrpt::fusion {

/** Writes messages in a thread of its own: a writer of DDS waits while too much is not
 * acknowledged. So a robot that is out of reach holds up no other robot. */
class MessageWriter {
 public:
  /** \param[in] writer The writer. It is deleted with this object. */
  explicit MessageWriter(dds_entity_t writer) : writer_(writer), thread_([this] { run(); }) {}
  MessageWriter(const MessageWriter&) = delete;
  MessageWriter& operator=(const MessageWriter&) = delete;
  ~MessageWriter();

  /** Takes a message. \return False if it must be tried again later: the last message still waits,
   * or the robot does not listen yet.
   * \exception std::runtime_error If the last message could not be sent. */
  bool write(const std::string& message);
  /** Waits until the robot has what was sent, or until a time. */
  void flush(std::chrono::steady_clock::time_point end);

 private:
  void run();

  dds_entity_t writer_;
  std::mutex mutex_;  // of all below
  std::condition_variable changed_;
  std::string waiting_;  // message that waits; empty: none
  bool is_ending_ = false;
  bool is_first_ = true;  // true until the robot has the first message
  dds_return_t failure_ = DDS_RETCODE_OK;
  std::thread thread_;  // the last member: it uses the others
};

}  // namespace mrpt::fusion
