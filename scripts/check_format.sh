#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# check_format.sh [--fix]: reports each place in the .cpp and .h files of the repository whose format
# differs from .clang-format's, and fails if there is one. --fix formats the files instead.
set -euo pipefail
cd "$(dirname "$0")/.."
case "${1:-}" in
  --fix) action=(-i) ;;
  '') action=(--dry-run --Werror) ;;
  *) sed -n '3,4s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
esac
# Releases differ in what they do with one style: 14 is Debian 12's.
program=$(command -v clang-format-14 || command -v clang-format)
git ls-files -z -- '*.cpp' '*.h' | xargs -0 -n 8 -P "$(nproc)" "$program" "${action[@]}"
