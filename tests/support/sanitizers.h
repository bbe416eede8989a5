// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/** \file
 * Tells whether this build has AddressSanitizer or ThreadSanitizer. */

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define MRPT_FUSION_HAS_SANITIZER true
#endif
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MRPT_FUSION_HAS_SANITIZER true
#endif
#ifndef MRPT_FUSION_HAS_SANITIZER
#define MRPT_FUSION_HAS_SANITIZER false
#endif

namespace map_tests {

/** True in builds with a sanitizer. They reserve terabytes of addresses, and AddressSanitizer ends
 * a process that finds no memory: a limit of the address space cannot be tested there. */
constexpr bool kHasSanitizer = MRPT_FUSION_HAS_SANITIZER;

}  // namespace map_tests
