// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/fusion/map_files.h>
#include <mrpt/obs/CObservation.h>

#include <set>
#include <string>
#include <vector>

/** \file
 * Counts the observations that a map is built without. */

namespace mrpt::fusion {

/** Counts observations that are inserted, and observations that are left out with their reasons. */
class ObservationCounter {
 public:
  void countInserted(const mrpt::obs::CObservation& obs) {
    inserted_++;
    inserted_kinds_.insert(kindOf(obs));
  }
  /** Counts an observation that no map took. */
  void countNotTaken(const mrpt::obs::CObservation& obs) { add(kindOf(obs), kNotTaken); }
  void countLeftOut(const std::string& kind, const std::string& reason, size_t count = 1) {
    add(kind, reason, count);
  }

  size_t inserted() const { return inserted_; }  ///< Number of observations that were inserted
  size_t leftOut() const;                        ///< Number of observations that were left out
  /** Returns the numbers by class and reason, in the order of the recording. */
  std::vector<LeftOut> reasons() const;

  static std::string kindOf(const mrpt::obs::CObservation& obs) {
    const std::string name = obs.GetRuntimeClass()->className;  // with namespaces
    return name.substr(name.rfind(':') + 1);
  }

 private:
  static constexpr const char* kNotTaken = "no map takes observations of this kind";
  void add(const std::string& kind, const std::string& reason, size_t count = 1);

  size_t inserted_ = 0;
  std::set<std::string> inserted_kinds_;
  std::vector<LeftOut> left_out_;
};

/** Returns "3 CObservationImage: <reason>, 2 ...", to end an error message. */
std::string toText(const std::vector<LeftOut>& left_out);

}  // namespace mrpt::fusion
