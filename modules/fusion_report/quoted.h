// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

/** \file
 * Names in files of YAML. */

namespace mrpt::fusion {

/** Returns a name as a string of YAML, whatever its bytes are. */
inline std::string quoted(const std::string& name) {
  return nlohmann::json(name).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace mrpt::fusion
