#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# build_page.sh [--check]: bundles the page of `map-fusion --report` (modules/fusion_report/page/web) with
# three.js from npm into one file, dist/page.html, which is kept in the project: a normal build needs
# neither npm nor a network. Needs Node.js 18 and npm. --check needs neither: it fails if the built page is
# older than its sources.
set -euo pipefail
cd "$(dirname "$0")/../modules/fusion_report/page/web"

if [ "${1-}" = --check ]; then
  sha256sum --check --quiet dist/sha256sums || { echo "the page is out of date: run scripts/build_page.sh" >&2; exit 1; }
  diff <(sed 's/^[^ ]*  //' dist/sha256sums | sort) \
    <(ls build.mjs package.json package-lock.json src/* dist/page.html | sort) ||
    { echo "other sources than the page was built from: run scripts/build_page.sh" >&2; exit 1; }
  exit 0
fi
npm ci --ignore-scripts --no-fund --no-audit
node build.mjs
