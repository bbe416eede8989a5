// SPDX-License-Identifier: BSD-3-Clause
#include "fusion_team/ledger/source.h"

#include <gtest/gtest.h>

namespace mrpt::fusion::test::source_test {
namespace {

TEST(SourceName, IsOrderedByRobotThenByMap) {
  EXPECT_LT((SourceName{"a", "z"}), (SourceName{"b", "a"}));
  EXPECT_LT((SourceName{"a", "a"}), (SourceName{"a", "b"}));
  EXPECT_FALSE((SourceName{"a", "a"}) < (SourceName{"a", "a"}));
}

}  // namespace
}  // namespace mrpt::fusion::test::source_test
