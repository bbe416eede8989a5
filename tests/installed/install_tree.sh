#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# install_tree.sh BUILD_DIR PREFIX: installs the build, then moves it: what is there must find its
# parts wherever it lies.
set -euo pipefail
build=$1 prefix=$2
rm -rf "$prefix" "$prefix.before"
cmake --install "$build" --prefix "$prefix.before"
mv "$prefix.before" "$prefix"
