// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

/** \file
 * Unpacks gzip data in memory, with a limit. */

namespace mrpt::fusion {

/** Returns whether the bytes begin like a gzip file. */
bool isGzip(std::string_view bytes);

/** Returns the unpacked bytes of a gzip file. Bytes after the last packed part are ignored, as
 * gunzip does.
 * \param[in] bytes The packed bytes.
 * \param[in] most Largest number of unpacked bytes.
 * \exception std::runtime_error If the data is damaged, ends early, or has more than \a most bytes.
 */
std::string gunzipped(std::string_view bytes, size_t most);

/** Returns at most the first \a most unpacked bytes of the beginning of a gzip file. Returns the
 * bytes before the first damage if the data is damaged. */
std::string gunzippedBeginning(std::string_view bytes, size_t most);

}  // namespace mrpt::fusion
