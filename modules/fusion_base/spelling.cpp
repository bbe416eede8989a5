// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Compares words. */

#include "fusion_base/spelling.h"

#include <algorithm>
#include <numeric>

namespace mrpt::fusion {

namespace {

/** Returns the number of letters to insert, remove or replace that make one word of the other. */
size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); i++) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); j++) {
      const size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

}  // namespace

std::pair<std::string, size_t> nearestTo(const std::string& word,
                                         const std::vector<std::string>& known) {
  std::pair<std::string, size_t> nearest{{}, std::string::npos};
  for (const std::string& other : known) {
    const size_t distance = editDistance(word.substr(0, kMostLetters), other);
    if (distance < nearest.second) nearest = {other, distance};
  }
  return nearest;
}

std::string textOfNearest(const std::string& word, const std::vector<std::string>& known) {
  const auto [nearest, changes] = nearestTo(word, known);
  const size_t letters = std::min(word.size(), kMostLetters);
  const bool is_near = changes != std::string::npos && 2 * changes < letters;
  return is_near ? "; the nearest is '" + nearest + "'" : "";
}

}  // namespace mrpt::fusion
