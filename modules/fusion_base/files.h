// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <string_view>

/** \file
 * Bytes from and to files: what goes wrong is said in one line, and no output is left half-written.
 */

namespace mrpt::fusion {

/** Whole contents of a file. \exception std::runtime_error If it cannot be read, or is empty. */
std::string readFileBytes(const std::string& path);

/** The first bytes of a file, to tell its kind by. \exception std::runtime_error As
 * readFileBytes(). */
std::string beginningOf(const std::string& path);

/** Takes the bytes of a file in pieces, one after the other. */
using ByteSink = std::function<void(std::string_view)>;

/** Writes a file so that either all of it is there or nothing has changed: into a temporary file
 * beside \a path, or beside what a link of that name leads to, flushed, then renamed. A device or a
 * pipe is written to as it is.
 * \exception std::runtime_error With the system's reason (full disk, no such directory...). */
void writeFileAtomically(const std::string& path, std::string_view bytes);

/** \overload
 * \param[in] path As above. \param[in] write Gives what it is called with all pieces of the file;
 * what it throws leaves nothing changed either. */
void writeFileAtomically(const std::string& path,
                         const std::function<void(const ByteSink&)>& write);

}  // namespace mrpt::fusion
