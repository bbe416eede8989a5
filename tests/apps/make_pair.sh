#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# make_pair.sh SIMULATE_ROBOTS MAP_FUSION SOURCE_DIR OUT: rawlogs, maps and true pose of two robots.
set -euo pipefail
simulate=$1 map_fusion=$2 source=$3 out=$4
mkdir -p "$out"
world=$("$source/scripts/find_geb079.sh" "$out")
"$simulate" "$source/tests/simulator/geb079.ini" --world "$world" --out "$out"
for robot in a b; do
  "$map_fusion" build "$out/robot_$robot.rawlog" -o "$out/map_$robot.ot"
done
