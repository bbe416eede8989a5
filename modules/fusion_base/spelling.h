// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

/** \file
 * Which known word is meant by a misspelt word. */

namespace mrpt::fusion {

constexpr size_t kMostLetters = 40;  // letters of an unknown word that are compared and printed

/** Returns the known word that is nearest to a word, and the number of letters to insert, remove or
 * replace that make one word of the other. */
std::pair<std::string, size_t> nearestTo(const std::string& word,
                                         const std::vector<std::string>& known);

/** Returns "; the nearest is '<word>'" if a known word differs in less than half of the letters,
 * else nothing. */
std::string textOfNearest(const std::string& word, const std::vector<std::string>& known);

}  // namespace mrpt::fusion
