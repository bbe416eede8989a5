#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Installs what is needed, builds everything in build/ with warnings as errors, runs all tests.
# Further arguments go to ctest, for example: scripts/test.sh -R Merging
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/install_dependencies.sh
export CMAKE_GENERATOR=Ninja # of a new build tree; an old tree keeps its own
# CMAKE_UNITY_BUILD: compiles files of one target together, in three quarters of the time.
cmake -S . -B build -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON -DMRPT_FUSION_WARNINGS_AS_ERRORS=ON
cmake --build build -j "$(nproc)"
# Many tests wait for files, for other programs, for thin links or for a browser: two tests for each core.
ctest --test-dir build --output-on-failure -j "$((2 * $(nproc)))" "$@"
