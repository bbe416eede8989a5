// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <ostream>

/** \file
 * Rows of the tables that the experiments write. */

namespace mrpt::fusion::benchmark {

/** Writes values separated by commas, and a newline. */
template <class First, class... Rest>
void writeRow(std::ostream& csv, const First& first, const Rest&... rest) {
  csv << first;
  ((csv << ',' << rest), ...);
  csv << '\n';
}

/** Returns "accepted", "rejected", or nothing. */
inline const char* verdictText(const std::optional<bool>& accepted) {
  if (!accepted) return "";
  return *accepted ? "accepted" : "rejected";
}

}  // namespace mrpt::fusion::benchmark
