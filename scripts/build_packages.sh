#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# build_packages.sh [--check]: builds the Debian packages of the committed tree in build/packages. --check
# then runs lintian, builds them again and compares the hashes. Installs the Debian packages that it needs.
set -euo pipefail
cd "$(dirname "$0")/.."
case "${1:-}" in
  '' | --check) ;;
  *) sed -n '3,4s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
esac

scripts/install_dependencies.sh --packages
version=$(dpkg-parsechangelog -S Version)
upstream=${version%-*}
SOURCE_DATE_EPOCH=$(dpkg-parsechangelog -S Timestamp)
export SOURCE_DATE_EPOCH

build() { # FOLDER: builds all packages in a new folder
  local folder=$1 tree=$1/mrpt-fusion-$upstream
  rm -rf "$folder"
  mkdir -p "$tree"
  git archive HEAD | tar -x -C "$tree"
  git archive --prefix="mrpt-fusion-$upstream/" HEAD ':!debian' |
    xz -6 >"$folder/mrpt-fusion_$upstream.orig.tar.xz"
  (cd "$tree" && dpkg-buildpackage -us -uc -j"$(nproc)") >"$folder/build.log" 2>&1 ||
    { tail -n 60 "$folder/build.log"; return 1; }
}

build build/packages
ls build/packages/*.deb
[ "${1:-}" = --check ] || exit 0

lintian --fail-on error,warning build/packages/*.changes
# In a folder with another name: it must not be in the packages.
build build/packages-again
for package in build/packages/*.deb; do
  cmp "$package" "build/packages-again/$(basename "$package")"
done
echo "lintian finds no error and no warning; two builds are equal"
