// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

/** \file
 * The page without data: markup, style and script, as scripts/build_page.sh builds it. */

namespace mrpt::fusion {

/** Returns the bytes of page/web/dist/page.html. CMake writes the function that returns them. */
std::string_view pageTemplate();

}  // namespace mrpt::fusion
