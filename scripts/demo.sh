#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Two robots map parts of one building, each in its own frame; mrpt-fusion makes one map of them.
# The building is real (Freiburg 079, from OctoMap's examples); the robots are simulated.
# Results go to build/demo.
set -euo pipefail
cd "$(dirname "$0")/.."

say() { printf '\n== %s\n' "$*"; }

say "Installing dependencies and building"
scripts/install_dependencies.sh
export CMAKE_GENERATOR=Ninja # of a new build tree; an old tree keeps its own
# CMAKE_UNITY_BUILD: compiles files of one target together, in three quarters of the time.
cmake -S . -B build -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON >build.log 2>&1 || { cat build.log; exit 1; }
cmake --build build -j "$(nproc)" --target map-fusion simulate-robots >>build.log 2>&1 ||
  { tail -n 50 build.log; exit 1; }
mv build.log build/build.log

out=build/demo
mkdir -p "$out"
world=$(scripts/find_geb079.sh "$out")

say "Driving two simulated lidar robots through the real building geb079"
build/bin/simulate-robots tests/simulator/geb079.ini --world "$world" --out "$out"

for robot in a b; do
  say "Building robot $robot's map from its rawlog"
  build/bin/map-fusion build "$out/robot_$robot.rawlog" -o "$out/map_$robot.ot"
done

say "Fusing the maps, from a guess that is off by 1 m and 10 deg"
# The guess: the truth, which only the simulator knows, moved by (0.8, -0.6) m and turned by 10 deg.
awk -v c=0.984807753 -v s=0.173648178 '
  { for (i = 1; i <= 4; i++) m[NR, i] = $i }
  END {
    for (i = 1; i <= 3; i++) { x[i] = c * m[1, i] - s * m[2, i]; y[i] = s * m[1, i] + c * m[2, i] }
    print x[1], x[2], x[3], m[1, 4] + 0.8; print y[1], y[2], y[3], m[2, 4] - 0.6
    print m[3, 1], m[3, 2], m[3, 3], m[3, 4]; print 0, 0, 0, 1
  }' "$out/T_a_b.txt" >"$out/guess.txt"
build/bin/map-fusion fuse "$out/map_a.ot" "$out/map_b.ot" --init "$out/guess.txt" \
  -o "$out/fused.ot" --pose-out "$out/T_a_b_estimated.txt" \
  --picture "$out/top_view.png" --json "$out/report.json" --report "$out/page.html"

say "The estimated pose of robot b's map in robot a's, and the simulation's truth"
paste -d '|' "$out/T_a_b_estimated.txt" "$out/T_a_b.txt" | awk -F '|' '
  { split($1, e, " "); split($2, t, " ")
    if (NR <= 3) for (i = 1; i <= 3; i++) trace += e[i] * t[i] # of R_e R_t
    if (NR <= 3) shift2 += (e[4] - t[4]) ^ 2 }
  END {
    c = (trace - 1) / 2; if (c > 1) c = 1
    printf "error: %.3f m, %.2f deg\n", sqrt(shift2), atan2(sqrt(1 - c * c), c) * 57.29578
  }'
cat <<EOF
The fused map:     $out/fused.ot      (octovis, or map-fusion info)
Seen from above:   $out/top_view.png
Every figure:      $out/report.json
See why:           $out/page.html     (a browser, or map-fusion view)
EOF
