// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * How programs of ours take their memory: by jemalloc, which looks for these settings by their
 * name.
 *
 * Octrees are millions of small nodes. In pages of 4 kB half the time that reading one takes goes
 * into page faults, so huge pages are asked for; and as such a program works on its maps and ends,
 * what is freed is kept for what comes next. */

extern "C" {
extern const char* malloc_conf;
const char* malloc_conf = "thp:always,dirty_decay_ms:-1,muzzy_decay_ms:-1";
}
