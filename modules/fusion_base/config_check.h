// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/config/CConfigFileBase.h>

#include <string>
#include <vector>

/** \file
 * Strict reading of settings. MRPT ignores a misspelt key, and reads text that is not a number as
 * 0. These functions throw instead. Upper and lower case of names do not matter, as in MRPT.
 */

namespace mrpt::fusion {

/** Checks that all keys of a section are in \a known.
 * \exception std::exception "[section] has an unknown key 'key'", with the nearest known
 * key. */
void checkKeys(const mrpt::config::CConfigFileBase& source, const std::string& section,
               const std::vector<std::string>& known);

/** Kind of numbers of a setting. */
enum class NumberKind {
  Real,  ///< All numbers
  Whole  ///< Integers
};

/** Reads the number at a key. \return \a value if there is no such key.
 * \exception std::exception "[section] key = text is not a number in [min, max]". */
double readNumber(const mrpt::config::CConfigFileBase& source, const std::string& section,
                  const std::string& key, double value, double min, double max,
                  NumberKind kind = NumberKind::Real);

/** Reads true/false, yes/no, on/off or 1/0 at a key. \return \a value if there is no such key.
 * \exception std::exception "[section] key = text is neither true nor false". */
bool readFlag(const mrpt::config::CConfigFileBase& source, const std::string& section,
              const std::string& key, bool value);

}  // namespace mrpt::fusion
