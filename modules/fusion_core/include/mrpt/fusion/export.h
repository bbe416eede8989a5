// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/** \file
 * Marks the symbols that the libraries export. All other symbols are hidden. */

/** Marks a function or class of the public headers: other programs may link to it. */
#define MRPT_FUSION_API __attribute__((visibility("default")))
