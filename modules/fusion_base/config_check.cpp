// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Checks keys and values of settings. */
#include "fusion_base/config_check.h"

#include <mrpt/core/exceptions.h>
#include <mrpt/core/format.h>
#include <mrpt/system/string_utils.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <sstream>

#include "fusion_base/spelling.h"

namespace mrpt::fusion {

void checkKeys(const mrpt::config::CConfigFileBase& source, const std::string& section,
               const std::vector<std::string>& known) {
  std::vector<std::string> keys;
  source.getAllKeys(section, keys);
  for (const auto& key : keys)
    ASSERTMSG_(std::any_of(known.begin(), known.end(),
                           [&](const auto& k) { return mrpt::system::strCmpI(key, k); }),
               "[" + section + "] has an unknown key '" + key + "'" + textOfNearest(key, known));
}

double readNumber(const mrpt::config::CConfigFileBase& source, const std::string& section,
                  const std::string& key, double value, double min, double max, NumberKind kind) {
  if (!source.keyExists(section, key)) return value;
  const bool whole = kind == NumberKind::Whole;
  const std::string text = source.read_string(section, key, "");
  std::istringstream in(text);
  std::string rest;
  const bool is_number = static_cast<bool>(in >> value) && !(in >> rest);
  ASSERTMSG_(is_number && value >= min && value <= max && (!whole || value == std::floor(value)),
             mrpt::format("[%s] %s = %s is not a %s in [%g, %g]", section.c_str(), key.c_str(),
                          text.c_str(), whole ? "whole number" : "number", min, max));
  return value;
}

bool readFlag(const mrpt::config::CConfigFileBase& source, const std::string& section,
              const std::string& key, bool value) {
  if (!source.keyExists(section, key)) return value;
  const std::string text = source.read_string(section, key, "");
  const auto isOneOf = [&](std::initializer_list<const char*> words) {
    return std::any_of(words.begin(), words.end(),
                       [&](const char* w) { return mrpt::system::strCmpI(text, w); });
  };
  const bool is_true = isOneOf({"true", "yes", "on", "1"});
  ASSERTMSG_(is_true || isOneOf({"false", "no", "off", "0"}),
             "[" + section + "] " + key + " = " + text + " is neither true nor false");
  return is_true;
}

}  // namespace mrpt::fusion
