// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Converts dicts to options, and the defaults to a dict. */

#include "settings.h"

#include <mrpt/config/CConfigFileMemory.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cctype>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "bindings.h"
#include "fusion_base/error_text.h"
#include "fusion_base/files.h"
#include "fusion_base/spelling.h"

using mrpt::fusion::kVerdictModelSection;
using mrpt::fusion::Options;

namespace mrpt_fusion_python {
namespace {

constexpr const char* kSection = "ProbabilisticMapMatching";

/** Returns a name or a value of a setting as the text of an .ini file. */
std::string wordOf(const py::handle& object) {
  if (py::isinstance<py::bool_>(object)) return object.cast<bool>() ? "true" : "false";
  const bool is_text = py::isinstance<py::str>(object);
  if (!is_text && !py::isinstance<py::float_>(object) && !PyIndex_Check(object.ptr()) &&
      !PyNumber_Check(object.ptr()))
    throw py::type_error("an option is a number or a word");
  const auto word =
      (is_text ? py::str(object) : py::str(py::float_(py::reinterpret_borrow<py::object>(object))))
          .cast<std::string>();
  const auto belongs = [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("_.+-").find(static_cast<char>(c)) != std::string_view::npos;
  };
  if (word.empty() || !std::all_of(word.begin(), word.end(), belongs))
    throw py::value_error("'" + word + "' is neither a name nor a value of an option");
  return word;
}

mrpt::config::CConfigFileMemory defaults() {
  mrpt::config::CConfigFileMemory file;
  Options().saveToConfigFile(file, kSection);
  mrpt::fusion::saveVerdictModel({}, file);
  return file;
}

std::vector<std::string> keysOf(const mrpt::config::CConfigFileBase& file,
                                const std::string& section) {
  std::vector<std::string> keys;
  file.getAllKeys(section, keys);
  return keys;
}

Options optionsOf(const std::string& text) {
  mrpt::config::CConfigFileMemory file;
  file.setContent(text);
  if (!file.sectionExists(kSection))
    throw std::runtime_error(std::string("has no section [") + kSection + "]");
  for (const char* section : {kSection, kVerdictModelSection}) checkKeys(file, defaults(), section);
  Options options;
  options.loadFromConfigFile(file, kSection);
  return options;
}

/** Returns a value of an .ini file as a number, or else as a text. */
py::object valueOf(const std::string& word) {
  for (PyTypeObject* type : {&PyLong_Type, &PyFloat_Type}) {
    try {
      return py::handle(reinterpret_cast<PyObject*>(type))(word);
    } catch (py::error_already_set& e) {
      if (!e.matches(PyExc_ValueError)) throw;
    }
  }
  return py::str(word);
}

py::dict dictOf(const mrpt::config::CConfigFileBase& file, const std::string& section) {
  py::dict values;
  for (const std::string& key : keysOf(file, section))
    values[py::str(key)] = valueOf(file.read_string(section, key, ""));
  return values;
}

py::dict defaultOptions() {
  const mrpt::config::CConfigFileMemory file = defaults();
  py::dict values = dictOf(file, kSection);
  values[kVerdictModelSection] = dictOf(file, kVerdictModelSection);
  return values;
}

}  // namespace

std::string pathOf(const py::object& path) {
  return py::module_::import("os").attr("fsencode")(path).cast<std::string>();
}

void checkKeys(const mrpt::config::CConfigFileBase& settings,
               const mrpt::config::CConfigFileBase& defaults, const std::string& section) {
  const std::vector<std::string> known = keysOf(defaults, section);
  for (const std::string& key : keysOf(settings, section)) {
    if (defaults.keyExists(section, key)) continue;
    throw std::runtime_error("[" + section + "] has an unknown key '" + key + "'" +
                             mrpt::fusion::textOfNearest(key, known));
  }
}

std::string iniText(const py::dict& values, const std::string& section) {
  std::string text = "[" + section + "]\n";
  for (const auto& [key, value] : values) text += wordOf(key) + " = " + wordOf(value) + "\n";
  return text;
}

Settings settingsOf(const py::object& options) {
  if (options.is_none()) return {};
  if (py::isinstance<py::dict>(options)) {
    py::dict values = options.attr("copy")();
    if (values.empty()) return {};
    std::string text;
    if (values.contains(kVerdictModelSection))
      text = iniText(values.attr("pop")(kVerdictModelSection), kVerdictModelSection);
    text = iniText(values, kSection) + text;
    return {optionsOf(text), text};
  }
  const std::string path = pathOf(options);
  constexpr size_t kMostBytes = size_t{16} << 20U;
  return mrpt::fusion::withPath(path, [&]() -> Settings {
    const std::string text = mrpt::fusion::readFileBytes(path, kMostBytes);
    return {optionsOf(text), text};
  });
}

void bindSettings(py::module_& m) {
  m.def("default_options", &defaultOptions,
        R"(default_options() -> dict

All options with their defaults, by their names in pmm.ini. Lengths are in m, angles in deg.
A dict with some of them is an argument of most functions of this module. The verdict's
model is a dict in the dict, with the name VerdictModel.

>>> mf.default_options()['merge_policy']
'bayes'
>>> mf.default_options()['search_translation']
2.5
>>> mf.match('a.ot', 'b.ot', options={'serch_yaw_deg': 5})
Traceback (most recent call last):
mrpt_fusion.Error: [ProbabilisticMapMatching] has an unknown key 'serch_yaw_deg'; the nearest is 'search_yaw_deg'
)");
}

}  // namespace mrpt_fusion_python
