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

stage "sanitizers of addresses and undefined behaviour"
cmake --preset asan >/dev/null
cmake --build --preset asan --target raysweep_tests raysweep_fuzz
ctest --preset asan --label-regex fuzz
# Not by ctest, which starts a process for each test: one of this build takes two seconds to load. Left out is what takes minutes
# there, and runs what others run.
export shards=2 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
export all_but=Projector.ItIsSoInVoxelsThatAreNoCubes:Projector.RolledAndInclinedDetectorsAreTakenByWholeColumns
all_but+=:Fire.IsTheIntegralOfEmissionAndTransmittanceAlongEachRay:Fire.IsSampledOnVoxelsOfItsOwn
all_but+=:Cube4Perspective.ReconstructsAnOrbit:Photo*.BallFromTwelveViews:PhotoFit.SmoothnessFollowsFromThePictures
sanitized() {
    local log=build-asan/tests_$1.log
    if ! GTEST_TOTAL_SHARDS=$shards GTEST_SHARD_INDEX=$1 timeout 2700 \
        build-asan/bin/raysweep_tests --gtest_filter="-$all_but" >"$log" 2>&1; then
        grep -E -B 20 'FAILED|runtime error' "$log" || tail -n 60 "$log"
        return 1
    fi
    tail -n 3 "$log"
}
export -f sanitized
seq 0 $((shards - 1)) | xargs -P "$shards" -I{} bash -c 'sanitized {}'

stage "done"
