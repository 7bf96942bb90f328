#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test: format, release build, and the core tests under ASan and UBSan.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh --tests

echo "== format"
# Not by git: an unpacked archive has to pass too.
find apps bench lib tests -name '*.h' -o -name '*.cpp' | xargs clang-format --dry-run -Werror

echo "== release build"
scripts/build.sh

echo "== tests"
ctest --preset release --parallel 2 --timeout 900

echo "== tests under address and undefined-behaviour sanitizers"
cmake --preset asan >/dev/null
cmake --build --preset asan --target raysweep_tests
# Suites that end in Slow compare with long Monte Carlo runs: what they touch, others touch too.
ctest --preset asan --parallel 2 --timeout 900 --exclude-regex 'Slow\.|cli\.|blender\.'
