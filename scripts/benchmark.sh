#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# benchmark.sh [--quick] [--data DIR]... [--out DIR] [--page FILE] [--jobs N]
#
# Runs the paper's experiments on this software beside PCL's methods: simulates the data sets, aligns,
# merges, and writes CSV, tables and figures to --out (default build/benchmark or build/benchmark-quick).
#   --quick      a few starts on one data set: shows that everything works, in minutes
#   --data DIR   also run on the pairs in DIR: each subfolder with map_a.ot, map_b.ot and T_a_b.txt
#   --page FILE  put the tables and figures into that page, where its markers are
#   --jobs N     experiments to run at a time, each on one core (default: as many as there are cores)
set -euo pipefail

quick=false out= page= jobs=$(nproc) data=()
while [ $# -gt 0 ]; do
  case $1 in
    --quick) quick=true ;;
    --data) data+=("$(realpath -e "${2:?}")"); shift ;;
    --out) out=$(realpath -m "${2:?}"); shift ;;
    --page) page=$(realpath -e "${2:?}"); shift ;;
    --jobs) jobs=${2:?}; shift ;;
    *) sed -n '3,11s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
  esac
  shift
done
if $quick && [ -n "$page" ]; then
  echo "benchmark.sh: --page takes the figures of a full run, not of --quick" >&2
  exit 2
fi
cd "$(dirname "$0")/.."
if [ -z "$out" ]; then out=build/benchmark$(if $quick; then echo -quick; fi); fi

scripts/install_dependencies.sh --benchmark
cmake -S . -B build -DCMAKE_BUILD_TYPE=Release -DMRPT_FUSION_BUILD_BENCHMARKS=ON
cmake --build build -j "$(nproc)" --target map-fusion simulate-robots fusion-benchmark

# Settings were chosen with the missions' own seeds; these are for reporting.
seed=1001
simulate() { # NAME MISSION WORLD
  local pair=$out/data/$1 made_by
  made_by=$(cat "tests/simulator/$2" build/bin/simulate-robots build/lib/libmrpt-fusion-maps.so |
    sha256sum)-$seed
  if [ "$(cat "$pair/made_by" 2>/dev/null)" != "$made_by" ]; then
    mkdir -p "$pair"
    build/bin/simulate-robots "tests/simulator/$2" --world "$3" --seed "$seed" --out "$pair" \
      --write-world "$pair/world.bt"
    build/bin/map-fusion build -q "$pair/robot_a.rawlog" -o "$pair/map_a.ot"
    build/bin/map-fusion build -q "$pair/robot_b.rawlog" -o "$pair/map_b.ot"
    build/bin/map-fusion build -q "$pair/all.rawlog" -o "$pair/reference.ot"
    echo "$made_by" >"$pair/made_by"
  fi
  pairs+=("$pair")
}
mkdir -p "$out/data"
pairs=()
simulate corridor geb079.ini "$(scripts/find_geb079.sh "$out/data")"
if ! $quick; then
  simulate lobby lobby.ini lobby
  simulate office office.ini office
fi
for folder in "${data[@]}"; do
  before=${#pairs[@]}
  for truth in "$folder"/*/T_a_b.txt; do
    if [ -s "$truth" ]; then pairs+=("$(dirname "$truth")"); fi
  done
  if [ ${#pairs[@]} -eq "$before" ]; then
    echo "benchmark.sh: $folder: has no subfolder with T_a_b.txt" >&2
    exit 1
  fi
done
twice=$(for pair in "${pairs[@]}"; do basename "$pair"; done | sort | uniq -d)
if [ -n "$twice" ]; then
  echo "benchmark.sh: two pairs are named $twice" >&2
  exit 1
fi

methods="icp icp_plane gicp ndt first_level pmm_paper no_search default"
# The starts are a grid of 5 x 5 x 5: strides that 5 does not divide meet all of its rows.
stride() { if $quick; then echo "--stride $1"; fi; }
rm -rf "$out/csv" "$out/figures"
for pair in "${pairs[@]}"; do
  for method in $methods; do echo starts "'$pair'" --method $method "$(stride 31)"; done
  echo edge_iterations "'$pair'" "$(stride 8)"
  echo overlap "'$pair'" "$(stride 6)"
  echo ablation "'$pair'" --stride "$(if $quick; then echo 62; else echo 4; fi)"
  echo merging "'$pair'"
  echo data "'$pair'"
done | sed 's/ *$//' >"$out/experiments.txt" # xargs takes a blank at the end for a continued line
xargs -P "$jobs" -L 1 build/bin/fusion-benchmark --out "$out/csv" <"$out/experiments.txt"

# One file per table, data sets and methods in the order of this script.
for folder in "$out"/csv/*/; do
  table=$(basename "$folder")
  for pair in "${pairs[@]}"; do
    name=$(basename "$pair")
    if [ -s "$folder$name.csv" ]; then
      cat "$folder$name.csv"
    else
      for method in $methods; do cat "$folder$name-$method.csv"; done
    fi
  done | awk 'NR == 1 { header = $0; print } $0 != header' >"$out/$table.csv"
done

/usr/bin/python3 tests/benchmark/report.py "$out" ${page:+--page "$page"}
echo "Tables: $out/tables.md; figures: $out/figures"
