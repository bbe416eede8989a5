// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/** \file
 * What the libraries give to the linker: all else is hidden. */

/** Marks a function or class of the public headers: other programs may link to it. */
#define MRPT_FUSION_API __attribute__((visibility("default")))
