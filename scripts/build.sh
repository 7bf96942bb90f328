#!/usr/bin/env bash
# Release build into build/; the command is build/bin/raysweep.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh
cmake --preset release >/dev/null
cmake --build --preset release "$@"
