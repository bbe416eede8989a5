// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/config/CConfigFileBase.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

/** \file
 * The parameters of a stage, as settings files have them. A stage lists its own parameters, each
 * with key, range, unit and meaning; loading, checking and saving follow from that list. */

namespace mrpt::fusion {

/** Ranges without an upper end. */
constexpr double kUnlimited = 1e9;

/** One parameter. It refers to the field of a Params struct, which must outlive it. */
struct Parameter {
  /** Reads the value at the key, if there is one. \exception std::exception On a value out of
   * range, naming section and key. */
  std::function<void(const mrpt::config::CConfigFileBase& source, const std::string& section)> load;
  std::function<std::string()> text;  ///< Value as written to a file; fractions in six digits
  std::function<double()> value;      ///< Value in the field; of a named value, its index
  std::string key;                    ///< Name in files; ends in `_deg` if the file has degrees
  std::string comment;                ///< Meaning and unit, one line
  bool is_advanced = false;           ///< True if few users need it
};

using Parameters = std::vector<Parameter>;  ///< Those of a stage, in their order in files

/** A number of any unit but degrees. */
Parameter number(const char* key, double& field, double min, double max, const char* comment);
/** An angle: radians in the field, degrees in the file. \param[in] min,max Degrees. */
Parameter angle(const char* key, double& field, double min, double max, const char* comment);
/** A whole number. */
Parameter count(const char* key, unsigned& field, double min, double max, const char* comment);
/** \overload */
Parameter count(const char* key, size_t& field, double min, double max, const char* comment);

/** Values of an enumeration and their names in files. */
template <class E>
using Names = std::vector<std::pair<E, const char*>>;

/** "a, b, c". */
template <class E>
std::string listOf(const Names<E>& names) {
  std::string list;
  for (const auto& n : names) list += (list.empty() ? "" : ", ") + std::string(n.second);
  return list;
}

/** Implementation of choice(). \param[in] get,set Index into \a names. */
Parameter namedValue(const char* key, std::vector<std::string> names, std::function<size_t()> get,
                     std::function<void(size_t)> set, const std::string& comment);

/** A value of an enumeration. \param[in] names All of its values; copied. */
template <class E>
Parameter choice(const char* key, E& field, const Names<E>& names, const std::string& comment) {
  std::vector<std::string> texts;
  std::vector<E> values;
  for (const auto& [value, name] : names) {
    values.push_back(value);
    texts.emplace_back(name);
  }
  return namedValue(
      key, texts,
      [&field, values] {
        return static_cast<size_t>(std::find(values.begin(), values.end(), field) - values.begin());
      },
      [&field, values](size_t i) { field = values[i]; }, comment);
}

/** Marks a parameter as one that few users need. */
Parameter advanced(Parameter p);

/** Loads all parameters that a section has. Missing keys keep their values.
 * \exception std::exception On a value out of range, or a key in the section that is no parameter.
 */
void loadParameters(const Parameters& parameters, const mrpt::config::CConfigFileBase& source,
                    const std::string& section);

/** Saves all parameters, each with its comment. */
void saveParameters(const Parameters& parameters, mrpt::config::CConfigFileBase& target,
                    const std::string& section);

}  // namespace mrpt::fusion
