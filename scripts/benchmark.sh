#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# benchmark.sh [--quick | --performance] [--data DIR]... [--out DIR] [--page FILE] [--jobs N]
#
# Runs the paper's experiments on this software beside PCL's methods: simulates the data sets, aligns,
# merges, and writes CSV, tables and figures to --out (default build/benchmark or build/benchmark-quick).
#   --quick      a few starts on one data set: shows that everything works, in minutes
#   --performance  measure instead how long a match takes beside PCL's, and each step on maps of up to
#                5 million voxels (doc/performance.md); wants an idle machine and 12 GB of memory
#   --data DIR   also run on the pairs in DIR: each subfolder with map_a.ot, map_b.ot and T_a_b.txt
#   --page FILE  put the tables and figures into that page, where its markers are
#   --jobs N     experiments to run at a time, each on one core (default: as many as there are cores)
set -euo pipefail

quick=false performance=false out= page= jobs=$(nproc) data=()
while [ $# -gt 0 ]; do
  case $1 in
    --quick) quick=true ;;
    --performance) performance=true ;;
    --data) data+=("$(realpath -e "${2:?}")"); shift ;;
    --out) out=$(realpath -m "${2:?}"); shift ;;
    --page) page=$(realpath -e "${2:?}"); shift ;;
    --jobs) jobs=${2:?}; shift ;;
    *) sed -n '3,13s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
  esac
  shift
done
if $quick && $performance; then
  echo "benchmark.sh: --quick runs the experiments and --performance, briefly: give one of them" >&2
  exit 2
fi
if $quick && [ -n "$page" ]; then
  echo "benchmark.sh: --page takes the figures of a full run, not of --quick" >&2
  exit 2
fi
cd "$(dirname "$0")/.."
if [ -z "$out" ]; then out=build/benchmark$(if $quick; then echo -quick; fi); fi

scripts/install_dependencies.sh --benchmark
export CMAKE_GENERATOR=Ninja # of a new build tree; an old tree keeps its own
cmake -S . -B build -DCMAKE_BUILD_TYPE=Release -DMRPT_FUSION_BUILD_BENCHMARKS=ON
cmake --build build -j "$(nproc)" \
  --target map-fusion simulate-robots fusion-benchmark tile-maps step-benchmark

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
run_experiments() {
  rm -rf "$out/figures"
  for pair in "${pairs[@]}"; do
    for method in $methods; do echo starts "'$pair'" --method $method "$(stride 31)"; done
    echo edge_iterations "'$pair'" "$(stride 8)"
    echo overlap "'$pair'" "$(stride 6)"
    echo ablation "'$pair'" --stride "$(if $quick; then echo 62; else echo 4; fi)"
    echo anywhere "'$pair'" "$(stride 10)"
    echo verdicts "'$pair'" "$(stride 10)"
    echo mixes "'$pair'" "$(stride 10)"
    echo merging "'$pair'"
    echo data "'$pair'"
  done | sed 's/ *$//' >"$out/experiments.txt" # xargs takes a blank at the end for a continued line
  xargs -P "$jobs" -L 1 build/bin/fusion-benchmark --out "$out/csv" <"$out/experiments.txt"
}

# One thing at a time: what runs beside it takes cache and memory bandwidth.
run_performance() {
  local rounds=5 repetitions=11 seconds=0.3 tilings="500k=2x5 5M=6x16" tiling small=${pairs[0]}
  local measured=("$small")
  if $quick; then rounds=1 repetitions=1 seconds=0 tilings="double=1x2"; fi
  for pair in "${pairs[@]}"; do
    build/bin/fusion-benchmark speed "$pair" --rounds $rounds --out "$out/csv"
  done
  for tiling in $tilings; do
    build/bin/tile-maps "$small" --copies "${tiling#*=}" --out "$out/tiled/${tiling%=*}"
    measured+=("$out/tiled/${tiling%=*}")
  done
  build/bin/step-benchmark "${measured[@]}" --benchmark_min_time=$seconds \
    --benchmark_repetitions=$repetitions --benchmark_enable_random_interleaving=true \
    --benchmark_out="$out/steps.json"
}

rm -rf "$out/csv"
if ! $performance; then run_experiments; fi
if $performance || $quick; then run_performance; fi

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

if ! $performance; then
  /usr/bin/python3 tests/benchmark/report.py "$out" ${page:+--page "$page"}
  echo "Tables: $out/tables.md; figures: $out/figures"
fi
if $performance || $quick; then
  /usr/bin/python3 tests/benchmark/performance.py "$out" ${page:+--page "$page"}
  echo "Times: $out/performance.md"
fi
