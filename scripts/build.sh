#!/usr/bin/env bash
# Release build into build/; the command is build/bin/raysweep. Arguments go to cmake --build (--target raysweep_app: just that).
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh
source scripts/ccache.sh
cmake --preset release >/dev/null
cmake --build --preset release "$@"
