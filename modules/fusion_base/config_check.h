// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/config/CConfigFileBase.h>

#include <string>
#include <vector>

/** \file
 * Reading settings so that nothing in them is silently ignored: MRPT takes a misspelt key for one
 * that is not there, and text that is no number for 0. Names are compared as MRPT finds them:
 * whatever their case.
 */

namespace mrpt::fusion {

/** \exception std::exception "[section] has an unknown key 'key'", if it has one not among
 * \a known. */
void checkKeys(const mrpt::config::CConfigFileBase& source, const std::string& section,
               const std::vector<std::string>& known);

/** Which numbers a setting takes. */
enum class NumberKind {
  Real,  ///< any
  Whole  ///< integers
};

/** The number at a key. \return \a value if there is no such key.
 * \exception std::exception "[section] key = text is not a number in [min, max]". */
double readNumber(const mrpt::config::CConfigFileBase& source, const std::string& section,
                  const std::string& key, double value, double min, double max,
                  NumberKind kind = NumberKind::Real);

/** The true/false, yes/no, on/off or 1/0 at a key. \return \a value if there is no such key.
 * \exception std::exception "[section] key = text is neither true nor false". */
bool readFlag(const mrpt::config::CConfigFileBase& source, const std::string& section,
              const std::string& key, bool value);

}  // namespace mrpt::fusion
