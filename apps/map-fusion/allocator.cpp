// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The settings of the allocator of our programs, jemalloc. jemalloc finds them by their name.
 *
 * An octree has millions of small nodes. With pages of 4 kB, half the time of reading an octree is
 * spent on page faults, so we use huge pages. Our programs run for a short time, so freed memory is
 * kept for later use. */

extern "C" {
extern const char* malloc_conf;
const char* malloc_conf = "thp:always,dirty_decay_ms:-1,muzzy_decay_ms:-1";
}
