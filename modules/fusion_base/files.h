// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <string_view>

/** \file
 * Reading and writing of whole files. Errors have messages of one line. No output file is
 * incomplete.
 */

namespace mrpt::fusion {

/** Returns the whole contents of a file, device or pipe.
 * \param[in] path The file.
 * \param[in] most Largest number of bytes.
 * \exception std::runtime_error If it cannot be read, is empty, or has more than \a most bytes. */
std::string readFileBytes(const std::string& path,
                          size_t most = std::numeric_limits<size_t>::max());

/** Returns at most the first 64 bytes of a file, which identify its format. For a gzip file they
 * are the first unpacked bytes. \exception std::runtime_error As readFileBytes(), and for pipes and
 * devices. */
std::string beginningOf(const std::string& path);

/** Function that receives the bytes of a file in consecutive pieces. */
using ByteSink = std::function<void(std::string_view)>;

/** Path that means standard output. "./-" is a file with this name. */
constexpr std::string_view kStandardOutput = "-";

/** Writes a whole file, or changes nothing. The bytes go to a temporary file beside \a path, which
 * is flushed and then renamed. If \a path is a link, the temporary file is beside the target of the
 * link. A file that is replaced keeps its rights. A device, a pipe or kStandardOutput is written in
 * place.
 * \exception std::runtime_error With the reason of the system (full disk, missing directory...). */
void writeFileAtomically(const std::string& path, std::string_view bytes);

/** \overload
 * \param[in] path The file.
 * \param[in] write Function that passes all pieces of the file to its argument. If it throws, the
 * file does not change. */
void writeFileAtomically(const std::string& path,
                         const std::function<void(const ByteSink&)>& write);

/** A file that grows, as a recording. */
class FileAppender {
 public:
  /** Opens a file, or makes it. \exception std::runtime_error "<path>: <reason>". */
  explicit FileAppender(std::string path);
  ~FileAppender();
  FileAppender(const FileAppender&) = delete;
  FileAppender& operator=(const FileAppender&) = delete;

  /** Appends bytes. They are with the system when the function returns: if the process is killed,
   * they stay. \exception std::runtime_error "<path>: <reason>" as of a full disk. The file is as
   * before then. */
  void append(std::string_view bytes);

 private:
  std::string path_;
  int fd_;
};

/** Removes the temporary files of all calls of writeFileAtomically() that have not returned. A
 * signal handler may call it before it ends the program. It knows the files of the library or
 * program that it is linked into. */
void removeTemporaryFiles() noexcept;

}  // namespace mrpt::fusion
