#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# build_tsan_tbb.sh [DIR]: builds Debian's version of oneTBB with -fsanitize=thread and installs it in
# DIR (default: build/tsan-tbb). ThreadSanitizer does not see how Debian's own build of TBB orders its
# threads, and therefore reports races that do not exist. Does nothing when DIR already has the library.
#
# Debian's source package comes through apt, with a list of sources of its own: the system's lists stay
# as they are. Needs dpkg-dev, cmake, clang. CXX names another compiler than clang++.
set -euo pipefail
dir=$(realpath -m "${1:-$(dirname "$0")/../build/tsan-tbb}")
compiler=${CXX:-clang++}

version=$(dpkg-query -W -f '${Version}' libtbb-dev)
made_by="onetbb $version, $("$compiler" --version | head -n 1)"
if [ "$(cat "$dir/made_by" 2>/dev/null)" = "$made_by" ]; then exit 0; fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
rm -rf "$dir"

# The places that the system gets packages from, asked for sources.
mkdir -p "$work"/apt/{sources,lists/partial,cache/archives/partial}
for list in /etc/apt/sources.list.d/*.sources; do
  if ! grep -qs debian "$list"; then continue; fi
  sed 's/^Types:.*/Types: deb-src/' "$list" >"$work/apt/sources/$(basename "$list")"
done
for list in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
  if ! grep -qs '^deb .*debian' "$list"; then continue; fi
  sed -n 's/^deb \(.*debian.*\)/deb-src \1/p' "$list" >"$work/apt/sources/$(basename "$list")"
done
cat >"$work/apt/apt.conf" <<EOF
Dir::Etc::SourceList "/dev/null";
Dir::Etc::SourceParts "$work/apt/sources";
Dir::State::Lists "$work/apt/lists";
Dir::Cache "$work/apt/cache";
APT::Sandbox::User "root";
Acquire::Retries "3";
EOF
export APT_CONFIG=$work/apt/apt.conf
apt-get update -q
(cd "$work" && apt-get source -q --only-source "onetbb=$version" >apt.log 2>&1) || {
  cat "$work/apt.log" >&2
  echo "build_tsan_tbb.sh: no source of onetbb $version" >&2
  exit 1
}

cmake -S "$work"/onetbb-*/ -B "$work/build" -DCMAKE_CXX_COMPILER="$compiler" \
  -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_INSTALL_PREFIX="$dir" -DCMAKE_INSTALL_LIBDIR=lib \
  -DTBB_SANITIZE=thread -DTBB_TEST=OFF -DTBBMALLOC_BUILD=OFF -DTBB_STRICT=OFF >"$work/build.log" 2>&1 &&
  cmake --build "$work/build" -j "$(nproc)" >>"$work/build.log" 2>&1 &&
  cmake --install "$work/build" >>"$work/build.log" 2>&1 || { tail -n 50 "$work/build.log" >&2; exit 1; }
echo "$made_by" >"$dir/made_by"
echo "TBB for ThreadSanitizer is in $dir"
