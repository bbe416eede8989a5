#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# install_dependencies.sh [--benchmark] [--ci] [--packages]: installs the Debian 12 packages that building,
# testing and the demo need. --benchmark adds what the benchmark needs, --ci adds clang and what its
# sanitizers, fuzzers and linters need, --packages adds what builds and checks Debian packages. Does
# nothing, and needs no rights, when they are all there.
set -euo pipefail

packages=(
  cmake g++ make ninja-build pkg-config
  libmrpt-maps-dev libmrpt-slam-dev # bring mrpt-obs, -opengl, -graphs..., Eigen and nanoflann
  liboctomap-dev                    # also holds the real building that the demo uses
  libeigen3-dev libceres-dev libtbb-dev libjemalloc-dev zlib1g-dev liblzma-dev libzstd-dev liblzf-dev
  libpng-dev
  libcli11-dev nlohmann-json3-dev
  cyclonedds-dev cyclonedds-tools   # map-fusion join: the link between robots
  pybind11-dev python3-dev python3-numpy python3-venv # the Python module
  libgtest-dev python3-pytest mypy man-db
  mrpt-apps mrpt-common             # tests: MRPT's programs, sample data
  doxygen                           # tests: every public symbol is documented
  iproute2 nftables                 # tests: thin links that lose packets
  openssl                           # certificates for robots that encrypt
  xvfb xauth imagemagick libgl1-mesa-dri # tests: windows and pictures of them, without a screen
)
for argument in "$@"; do
  case $argument in
    --benchmark) packages+=(libpcl-dev libbenchmark-dev python3-matplotlib) ;;
    --ci)
      packages+=(
        clang libclang-rt-14-dev llvm # sanitizers, libFuzzer, names of functions in their reports
        clang-format clang-tidy git
        chromium                      # tests: pages in a browser
        dpkg-dev                      # the source of TBB, which ThreadSanitizer needs
      )
      ;;
    --packages) packages+=(debhelper dh-python dpkg-dev fakeroot git lintian xz-utils) ;;
    *) echo "install_dependencies.sh: no option $argument" >&2; exit 2 ;;
  esac
done

missing=()
for p in "${packages[@]}"; do
  dpkg-query -W -f '${Status}' "$p" 2>/dev/null | grep -q 'ok installed' || missing+=("$p")
done
[ ${#missing[@]} -eq 0 ] && exit 0

sudo=()
if [ "$(id -u)" -ne 0 ]; then sudo=(sudo); fi
echo "Installing: ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
"${sudo[@]}" apt-get update -q
"${sudo[@]}" apt-get install -q -y --no-install-recommends "${missing[@]}"
