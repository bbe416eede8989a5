#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# fuzz.sh [SECONDS] [TARGET]...: builds the fuzz targets (tests/fuzz) with clang and runs each of them, or
# those given, for SECONDS (default 60), as many at a time as there are cores. Inputs that reach new
# code are kept in build/fuzz/corpus. Fails if a target finds a fault; the input is then in
# build/fuzz/faults. Environment: SEED, a number, makes each run try the same inputs (default: random).
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-60}
shift || true

cmake --preset fuzz
cmake --build --preset fuzz -j "$(nproc)"
bin=build/fuzz/bin
faults=build/fuzz/faults
targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then
  for program in "$bin"/*_fuzzer; do targets+=("$(basename "$program" _fuzzer)"); done
fi
mkdir -p "$faults"

run() { # TARGET
  local corpus=build/fuzz/corpus/$1 log=build/fuzz/$1.log known=tests/fuzz/regressions/$1
  "$bin/fuzz_replay" --seeds "$1" "$corpus" >"$log" 2>&1 || { cat "$log"; return 1; }
  if [ ! -d "$known" ]; then known=; fi
  # A hang is an input that takes longer than 30 s with sanitizers on a busy machine.
  if "$bin/$1_fuzzer" "$corpus" $known -max_total_time="$seconds" -seed="${SEED:-0}" -timeout=30 \
    -rss_limit_mb=2048 -max_len=16384 -artifact_prefix="$faults/$1-" -print_final_stats=1 \
    >"$log" 2>&1; then
    echo "$1: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") inputs, no fault"
  else
    tail -n 40 "$log"
    echo "$1: a fault; its input is $(ls -t "$faults/$1-"* 2>/dev/null | head -n 1)"
    return 1
  fi
}
export -f run
export bin faults seconds
printf '%s\n' "${targets[@]}" | xargs -P "$(nproc)" -I{} bash -c 'run {}'
