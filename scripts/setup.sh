#!/usr/bin/env bash
# Installs what Raysweep needs on Debian 12: only what is missing, with sudo only when not root.
# --tests: also what only tests need.
set -euo pipefail

packages=(
    build-essential cmake ninja-build ccache git
    libopenvdb-dev libboost-iostreams-dev libblosc-dev libtbb-dev libimath-dev libopenexr-dev libopenimageio-dev openimageio-tools libtiff-dev
    libhwy-dev libcli11-dev nlohmann-json3-dev libkissfft-dev libhdf5-dev libpugixml-dev libassimp-dev
    libinsighttoolkit5-dev libdcmtk-dev zlib1g-dev
    libgtest-dev libbenchmark-dev clang-format gnuplot-nox python3
)
case "${1:-}" in
    --tests) packages+=(blender python3-numpy verilator yosys) ;;
    "") ;;
    *) echo "usage: scripts/setup.sh [--tests]" >&2 && exit 2 ;;
esac

missing=()
for package in "${packages[@]}"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

sudo=""
[ "$(id -u)" -eq 0 ] || sudo="sudo"
echo "installing: ${missing[*]}"
$sudo apt-get update -qq
$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
