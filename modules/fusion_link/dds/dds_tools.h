// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <dds/dds.h>

#include <memory>
#include <stdexcept>
#include <string>

/** \file
 * Errors and settings of CycloneDDS. */

namespace mrpt::fusion {

/** Returns the result of a call. \exception std::runtime_error If it is an error. */
inline dds_entity_t checked(dds_entity_t result, const char* what) {
  if (result < 0)
    throw std::runtime_error(std::string("DDS: ") + what + ": " + dds_strretcode(-result));
  return result;
}

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

}  // namespace mrpt::fusion
