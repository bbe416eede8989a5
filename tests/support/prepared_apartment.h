// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <mrpt/fusion/options.h>
#include <mrpt/fusion/prepared_map.h>

#include "support/apartment_pair.h"

/** \file
 * The pair of apartment maps, prepared for matching. */

namespace mrpt::fusion::test {

/** A test that reads the pair. The maps are made once. */
class WithPreparedApartment : public testing::Test {
 protected:
  static const ApartmentPair& maps() {
    static const ApartmentPair pair(0.2);
    return pair;
  }
  static const PreparedMap& a() {
    static const PreparedMap map(*maps().map_a);
    return map;
  }
  static const PreparedMap& b() {
    static const PreparedMap map(*maps().map_b);
    return map;
  }
  /** Returns options that accept each pose with pairs that has no rival. */
  static Options credulous() {
    Options options;
    EvaluationParams& e = options.evaluation;
    e.max_free_conflict = 1;
    e.min_overlap = e.min_probability = 0;
    e.min_threshold = e.max_threshold = 0;
    return options;
  }
  const Eigen::Isometry3d truth = maps().truth;
};

}  // namespace mrpt::fusion::test
