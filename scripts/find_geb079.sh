#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# find_geb079.sh DIR: prints where the real building geb079.bt of liboctomap-dev's examples is. If the
# installation compressed it or left it out (as container images do with documentation), it is put
# into DIR.
set -euo pipefail
dir=$1
examples=/usr/share/doc/liboctomap-dev/examples/data
world=$examples/geb079.bt
if [ ! -f "$world" ]; then
  world=$dir/geb079.bt
  if [ ! -s "$world" ]; then
    if [ -f "$examples/geb079.bt.gz" ]; then
      gunzip -c "$examples/geb079.bt.gz" >"$world.part"
    else
      (cd "$dir" && apt-get download -q liboctomap-dev >&2)
      dpkg-deb --fsys-tarfile "$dir"/liboctomap-dev_*.deb |
        tar -xO --wildcards '*/geb079.bt*' >"$world.part"
      if gunzip -t "$world.part" 2>/dev/null; then
        gunzip <"$world.part" >"$world.plain" && mv "$world.plain" "$world.part"
      fi
      rm -f "$dir"/liboctomap-dev_*.deb
    fi
    mv "$world.part" "$world"
  fi
fi
echo "$world"
