#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# check_wheel.sh: installs the Python module by pip into a new environment, without a network, and fuses two
# parts of the real building of OctoMap's examples with it.
set -euo pipefail
cd "$(dirname "$0")/.."
venv=$PWD/build/venv
rm -rf "$venv"
/usr/bin/python3 -m venv --system-site-packages "$venv"
PIP_NO_INDEX=1 "$venv/bin/pip" install -q .

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
make_maps=$PWD/debian/tests/make_maps.py
cd "$folder"
"$venv/bin/python" "$make_maps"
"$venv/bin/python" -c "
import mrpt_fusion as mf
r = mf.fuse(['a.ot', 'b_in_a.ot'])
print(r.accepted, r.pose)
assert mf.__file__.startswith('$venv') and r.accepted and abs(r.pose[:3, 3]).max() < 0.2
"
