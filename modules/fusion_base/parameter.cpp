// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Loads and saves lists of parameters. */
#include "fusion_base/parameter.h"

#include <mrpt/core/exceptions.h>
#include <mrpt/core/format.h>

#include <cmath>

#include "fusion_base/config_check.h"

namespace mrpt::fusion {
namespace {

/** Makes the parameter of a number. If \a is_degrees, the file has degrees and the field has
 * radians. */
template <class T>
Parameter numeric(const char* key, T& field, double min, double max, const char* comment,
                  NumberKind kind, bool is_degrees = false) {
  Parameter p;
  p.key = key;
  p.comment = comment;
  p.load = [=, &field](const mrpt::config::CConfigFileBase& source, const std::string& section) {
    if (!source.keyExists(section, key)) return;
    const double value = readNumber(source, section, key, 0, min, max, kind);
    field = static_cast<T>(is_degrees ? value * M_PI / 180 : value);
  };
  p.value = [&field] { return static_cast<double>(field); };
  p.text = [=, &field] {
    const auto value = static_cast<double>(field);
    if (kind == NumberKind::Whole) return mrpt::format("%.0f", value);
    // Six digits: 80 deg must not become 79.99999999999999.
    return mrpt::format("%g", is_degrees ? value * 180 / M_PI : value);
  };
  return p;
}

}  // namespace

Parameter number(const char* key, double& field, double min, double max, const char* comment) {
  return numeric(key, field, min, max, comment, NumberKind::Real);
}

Parameter length(const char* key, double& field, double min, double max, const char* comment) {
  Parameter p = number(key, field, min, max, comment);
  p.multiply = [&field](double factor) { field *= factor; };
  return p;
}

Parameter angle(const char* key, double& field, double min, double max, const char* comment) {
  constexpr bool kIsDegrees = true;
  return numeric(key, field, min, max, comment, NumberKind::Real, kIsDegrees);
}

Parameter count(const char* key, unsigned& field, double min, double max, const char* comment) {
  return numeric(key, field, min, max, comment, NumberKind::Whole);
}

Parameter count(const char* key, size_t& field, double min, double max, const char* comment) {
  return numeric(key, field, min, max, comment, NumberKind::Whole);
}

Parameter namedValue(const char* key, const std::vector<std::string>& names,
                     std::function<size_t()> get, std::function<void(size_t)> set,
                     const std::string& comment) {
  Parameter p;
  p.key = key;
  p.comment = comment;
  p.value = [get] { return static_cast<double>(get()); };
  p.text = [names, get = std::move(get)] { return names[get()]; };
  p.load = [key = p.key, names, set = std::move(set)](const mrpt::config::CConfigFileBase& source,
                                                      const std::string& section) {
    if (!source.keyExists(section, key)) return;
    const std::string text = source.read_string(section, key, "");
    const auto found = std::find(names.begin(), names.end(), text);
    std::string list;
    for (const auto& n : names) list += (list.empty() ? "" : ", ") + n;
    ASSERTMSG_(found != names.end(),
               "[" + section + "] " + key + " = " + text + " is none of " + list);
    set(static_cast<size_t>(found - names.begin()));
  };
  return p;
}

Parameter advanced(Parameter p) {
  p.is_advanced = true;
  return p;
}

void multiplyLengths(const Parameters& parameters, double factor) {
  for (const Parameter& p : parameters)
    if (p.multiply) p.multiply(factor);
}

void loadParameters(const Parameters& parameters, const mrpt::config::CConfigFileBase& source,
                    const std::string& section) {
  std::vector<std::string> keys;
  for (const Parameter& p : parameters) keys.push_back(p.key);
  checkKeys(source, section, keys);
  for (const Parameter& p : parameters) p.load(source, section);
}

void saveParameters(const Parameters& parameters, mrpt::config::CConfigFileBase& target,
                    const std::string& section) {
  for (const Parameter& p : parameters)
    target.write(section, p.key, p.text(), -1, -1, (p.is_advanced ? "Advanced. " : "") + p.comment);
}

}  // namespace mrpt::fusion
