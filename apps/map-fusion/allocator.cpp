// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The settings of the allocator of our programs, jemalloc. jemalloc finds them by their name.
 *
 * An octree has millions of small nodes. With pages of 4 kB, half the time of reading an octree is
 * spent on page faults, so we use huge pages. Our programs run for a short time, so freed memory is
 * kept for later use. All later use must find it:
 *  - There is one arena, also for large requests. A thread does not use what is free in the arena
 * of another thread. Bins of the arena are split, so that threads rarely wait for each other.
 *  - Requests may be far smaller than the free extents that they divide. By default jemalloc takes
 *    new memory for them.
 *
 * Nodes and their arrays of children, 16 and 64 bytes, lie in slabs of 64 kB: each slab is a search
 * for memory. */

#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <string_view>

#define MAP_FUSION_ALLOCATOR                                                      \
  "thp:always,dirty_decay_ms:-1,muzzy_decay_ms:-1,narenas:1,bin_shards:1-160:16," \
  "oversize_threshold:0,lg_extent_max_active_fit:24,slab_sizes:16-64:16"

extern "C" {
extern const char* malloc_conf;
const char* malloc_conf = MAP_FUSION_ALLOCATOR;
}

namespace {

/** Prepares for little memory if the address space is limited (ulimit -v). */
void prepareForLittleMemory() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  // jemalloc 5.3 crashes if a new thread finds no memory for an arena or for a cache of its own:
  // there is one arena, and here no thread has a cache. It also crashes if there is too little
  // memory for its own start and for the constructors of libraries.
  malloc_conf = MAP_FUSION_ALLOCATOR ",tcache:false";
  constexpr size_t kStart = size_t{12} << 20U;
  void* start = ::mmap(nullptr, kStart, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (start != MAP_FAILED) {
    ::munmap(start, kStart);
    return;
  }
  constexpr std::string_view kMessage = "map-fusion: out of memory\n";
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, kMessage.data(), kMessage.size());
  ::_exit(1);
}

// The functions of this section run before the constructors of all libraries. The first of these
// that allocates makes jemalloc read its settings.
[[gnu::section(".preinit_array"),
  gnu::used]] void (*const before_libraries)() = prepareForLittleMemory;

}  // namespace
