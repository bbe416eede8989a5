// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Counts the observations that a map is built without. */

#include "mrpt_fusion_maps/recordings/left_out.h"

#include <algorithm>

namespace mrpt::fusion {

void ObservationCounter::add(const std::string& kind, const std::string& reason, size_t count) {
  if (count == 0) return;
  const auto known = std::find_if(left_out_.begin(), left_out_.end(), [&](const LeftOut& l) {
    return l.kind == kind && l.reason == reason;
  });
  if (known != left_out_.end())
    known->count += count;
  else
    left_out_.push_back({kind, reason, count});
}

size_t ObservationCounter::leftOut() const {
  size_t sum = 0;
  for (const auto& l : left_out_) sum += l.count;
  return sum;
}

std::vector<LeftOut> ObservationCounter::reasons() const {
  std::vector<LeftOut> reasons = left_out_;
  for (auto& l : reasons)  // a map took other observations of this kind
    if (l.reason == kNotTaken && inserted_kinds_.count(l.kind) > 0)
      l.reason = "it has no points, or it is too far away for the map";
  return reasons;
}

std::string toText(const std::vector<LeftOut>& left_out) {
  std::string text;
  for (const auto& l : left_out)
    text += (text.empty() ? "" : "; ") + std::to_string(l.count) + " " + l.kind + ": " + l.reason;
  return text;
}

}  // namespace mrpt::fusion
