#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test: format, release build, and the units under sanitizers of addresses and
# undefined behaviour. Benchmarks are built, so that changes cannot break them, but not run; CONTRIBUTING.md says how to run what is
# parallel under ThreadSanitizer.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh --tests
source scripts/ccache.sh

stage() { printf '== %s (%d:%02d)\n' "$1" $((SECONDS / 60)) $((SECONDS % 60)); }

stage "format"
# Not by git: an unpacked archive has to pass too.
find apps bench hardware lib tests -name '*.h' -o -name '*.cpp' | xargs clang-format --dry-run -Werror

stage "release build"
scripts/build.sh

stage "tests"
ctest --preset release --parallel 2 --timeout 900

stage "tests under address and undefined-behaviour sanitizers"
cmake --preset asan >/dev/null
cmake --build --preset asan --target raysweep_tests
ctest --preset asan --parallel 2 --timeout 900 --exclude-regex 'Slow\.|cli\.|blender\.'

stage "done"
