// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "fusion_team/ledger/ledger.h"
#include "fusion_team/pairs/pair_memory.h"

/** \file
 * What a team that changes keeps from fusion to fusion. */

namespace mrpt::fusion {

/** The results of pairs, and the ledger of the fused map. The results of a fusion do not depend on
 * it. */
struct TeamMemory {
  PairMemory pairs;              ///< Results of pairs
  std::optional<Ledger> ledger;  ///< Ledger of the last fused map
  SourceName reference;          ///< Reference of the ledger
  uint64_t sequence = 0;         ///< Sequence of the last source in the ledger
};

}  // namespace mrpt::fusion
