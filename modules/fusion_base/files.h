// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <string_view>

/** \file
 * Reading and writing of whole files. Errors have messages of one line. No output file is
 * incomplete.
 */

namespace mrpt::fusion {

/** Returns the whole contents of a file.
 * \exception std::runtime_error If it cannot be read, or is empty. */
std::string readFileBytes(const std::string& path);

/** Returns at most the first 64 bytes of a file, which identify its format.
 * \exception std::runtime_error As readFileBytes(), and for pipes and devices. */
std::string beginningOf(const std::string& path);

/** Function that receives the bytes of a file in consecutive pieces. */
using ByteSink = std::function<void(std::string_view)>;

/** Writes a whole file, or changes nothing. The bytes go to a temporary file beside \a path, which
 * is flushed and then renamed. If \a path is a link, the temporary file is beside the target of the
 * link. A device or a pipe is written in place.
 * \exception std::runtime_error With the reason of the system (full disk, missing directory...). */
void writeFileAtomically(const std::string& path, std::string_view bytes);

/** \overload
 * \param[in] path The file.
 * \param[in] write Function that passes all pieces of the file to its argument. If it throws, the
 * file does not change. */
void writeFileAtomically(const std::string& path,
                         const std::function<void(const ByteSink&)>& write);

}  // namespace mrpt::fusion
