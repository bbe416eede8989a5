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
 * The parameters of a stage in settings files. Each stage lists its parameters with key, range,
 * unit and meaning. The list defines loading, checking and saving. */

namespace mrpt::fusion {

/** Upper limit of ranges without an upper limit. */
constexpr double kUnlimited = 1e9;

/** One parameter. It refers to the field of a Params struct, which must outlive it. */
struct Parameter {
  /** Function that reads the value at the key, if the key exists. It throws std::exception with
   * section and key if the value is out of range. */
  std::function<void(const mrpt::config::CConfigFileBase& source, const std::string& section)> load;
  std::function<std::string()> text;  ///< Value as written to a file; fractions in six digits
  std::function<double()> value;      ///< Value in the field; of a named value, its index
  std::string key;                    ///< Name in files; ends in `_deg` if the file has degrees
  std::string comment;                ///< Meaning and unit, one line
  bool is_advanced = false;           ///< True if few users need it
  /** Function that multiplies the field by a factor; empty if the parameter is no length(). */
  std::function<void(double factor)> multiply;
};

using Parameters = std::vector<Parameter>;  ///< Parameters of a stage, in their order in files

/** Makes the parameter of a number that keeps its value at any scale, in any unit except degrees.
 */
Parameter number(const char* key, double& field, double min, double max, const char* comment);
/** Makes the parameter of a length in m that multiplyLengths() multiplies. */
Parameter length(const char* key, double& field, double min, double max, const char* comment);
/** Makes the parameter of an angle: radians in the field, degrees in the file and in the range. */
Parameter angle(const char* key, double& field, double min, double max, const char* comment);
/** Makes the parameter of a whole number. */
Parameter count(const char* key, unsigned& field, double min, double max, const char* comment);
/** \overload */
Parameter count(const char* key, size_t& field, double min, double max, const char* comment);

/** Values of an enumeration with their names in files. */
template <class E>
using Names = std::vector<std::pair<E, const char*>>;

/** Returns the names as "a, b, c". */
template <class E>
std::string listOf(const Names<E>& names) {
  std::string list;
  for (const auto& n : names) list += (list.empty() ? "" : ", ") + std::string(n.second);
  return list;
}

/** Implements choice(). \a get and \a set access the index into \a names. */
Parameter namedValue(const char* key, const std::vector<std::string>& names,
                     std::function<size_t()> get, std::function<void(size_t)> set,
                     const std::string& comment);

/** Makes the parameter of an enumeration. \a names holds all of its values and is copied. */
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

/** Marks a parameter that few users need. */
Parameter advanced(Parameter p);

/** Multiplies the fields of all lengths by a factor. */
void multiplyLengths(const Parameters& parameters, double factor);

/** Loads the parameters in a section. Missing keys keep their values.
 * \exception std::exception If a value is out of range, or a key of the section is no parameter. */
void loadParameters(const Parameters& parameters, const mrpt::config::CConfigFileBase& source,
                    const std::string& section);

/** Saves all parameters, each with its comment. */
void saveParameters(const Parameters& parameters, mrpt::config::CConfigFileBase& target,
                    const std::string& section);

}  // namespace mrpt::fusion
