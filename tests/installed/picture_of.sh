#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# picture_of.sh PICTURE OTHER PIXELS PROGRAM ARGUMENTS...: starts a program on a screen of its own,
# and takes a picture of the screen once it is painted, stays as it is, and differs from another
# picture in so many pixels (OTHER may be "": there is none). Ends the program. Fails if that has
# not come to pass within 30 s, or the program has ended.
set -euo pipefail
if [ -z "${PICTURE_SCREEN:-}" ]; then
  # Software rendering, and neither the user's settings nor desktop. One at a time: two that look for
  # a free screen in the same moment find the same.
  lock=${TMPDIR:-/tmp}/picture_of.$(id -u).lock
  PICTURE_SCREEN=1 HOME=$PWD NO_AT_BRIDGE=1 LIBGL_ALWAYS_SOFTWARE=1 \
    exec flock -o "$lock" xvfb-run -a -s "-screen 0 1024x768x24" "$0" "$@"
fi
picture=$1 other=$2 pixels=$3
shift 3

"$@" &
program=$!
trap 'kill -KILL $program 2>/dev/null || true' EXIT

# Windows of many colours are painted: what is blank, or no more than framed, has few.
seen=""
for _ in $(seq 60); do
  sleep 0.5
  kill -0 $program 2>/dev/null || { echo "$1 has ended" >&2; exit 1; }
  import -silent -window root "$picture"
  last=$seen
  seen=$(identify -format '%#' "$picture")
  [ "$seen" = "$last" ] && [ "$(identify -format '%k' "$picture")" -gt 256 ] || continue
  [ -n "$other" ] || exit 0
  differing=$(compare -metric AE "$picture" "$other" null: 2>&1) || true
  [ "${differing%%.*}" -ge "$pixels" ] && exit 0
done
echo "$1 shows nothing${other:+ new} within 30 s${differing:+: $differing pixels differ}" >&2
exit 1
