#!/usr/bin/env bash
# What the Cube-4 emulator counts, and what narrow numbers cost: cycles, stalls, words between neighbours and bytes over
# pipelines and sizes; the time of the paper's two runs of 1000 passes; RMS of illumination and of SART against floats over
# widths, roundings, zeta and relaxation; and which contrast is left in what is reconstructed.
# Usage: bench/quality/cube4_figures.sh [FOLDER (bench/cube4_figures)]; about 25 minutes on one core. SHORT=1: small, in a
# minute, for whether it runs. RAYSWEEP=FILE, RAYSWEEP_CUBE4=FILE: those programs instead of a new build. docs/cube4.md says
# what is found.
set -euo pipefail
out=$(realpath -m "${1:-$(dirname "$0")/../cube4_figures}")
cd "$(dirname "$0")/../.."

[ -n "${RAYSWEEP:-}" ] && [ -n "${RAYSWEEP_CUBE4:-}" ] ||
    scripts/build.sh --target raysweep_app --target raysweep_cube4_app >/dev/null
raysweep=${RAYSWEEP:-build/bin/raysweep} cube4=${RAYSWEEP_CUBE4:-build/bin/raysweep-cube4}
sizes=(8 32 64 128) pipelines=(1 4 5 7 16 24 64) largest=256 room=276 engine=256,256,110
cloud=48 sweeps=60 zetas=(0.02 0.1 0.5) widths=(8 10 12 16 20 24)
voxelWidths=(8 10 12 14 16 20 24) relaxations=(0.02:60 0.1:20 0.2:20 1:10) # and passes
[ -z "${SHORT:-}" ] || {
    sizes=(16 32) pipelines=(1 4 5 16) largest=40 room=48 engine=40,40,24
    cloud=16 sweeps=10 zetas=(0.5) widths=(8 16) voxelWidths=(8 16 24) relaxations=(0.2:2 1:1)
}
roundings=(truncate nearest stochastic)
work=$out/work # volumes, records and reports
rm -rf "$work"
mkdir -p "$work"

# Light is absorbed where it is met: nothing is left to be shot, and no sweep is made but these. Cycles do not depend on values.
count() { # VOLUME NAME SWEEPS PIPELINES OPTIONS...
    $cube4 illuminate "$1" -o "$work/swept.vdb" --sky 1 --albedo 0 --sweeps "$3" --pipelines "$4" --report "$work/$2.json" \
        --quiet "${@:5}" >/dev/null
}
record_views() { # SIZE_X,Y,Z NAME VIEWS: a box, seen from around, one voxel a pixel
    local x z
    IFS=, read -r x _ z <<<"$1"
    local turn=(--parallel --first-angle 10 --detector "$((x * 3 / 2)),$((z + 2)),1")
    $raysweep generate box -o "$work/box.vdb" --dims "$1" --voxel-size 1 --quiet
    $raysweep project "$work/box.vdb" -o "$work/box.mha" --views "$3" "${turn[@]}" --quiet
    $raysweep ct "$work/box.mha" -o "$work/found.vdb" "${turn[@]}" --size "$1" --spacing 1 --iterations 1 --support none \
        --record "$work/$2.json" --quiet
}
count_views() { # RECORD NAME PIPELINES OPTIONS...
    $cube4 reconstruct --replay "$work/$1.json" --pipelines "$3" --report "$work/$2.json" --quiet "${@:4}" >/dev/null
}

# Cycles over pipelines and sizes.
for size in "${sizes[@]}" $largest; do
    six=6 views=4 some=("${pipelines[@]}")
    [ "$size" != $largest ] || { six=2 views=2 some=(1 4 16 64); }
    record_views "$size,$size,$size" "views-$size" $views
    for p in "${some[@]}"; do
        count "$work/box.vdb" "count-illuminate-$size-$p" $six "$p"
        count_views "views-$size" "count-reconstruct-$size-$p" "$p"
        [ "$size" != $largest ] || continue
        count "$work/box.vdb" "count-illuminate-$size-$p-shared" $six "$p" --no-overlap
        count_views "views-$size" "count-reconstruct-$size-$p-shared" "$p" --no-overlap
    done
done

# The paper's runs: light in the engine room, and the engine reconstructed.
$raysweep generate engine-room -o "$work/room.vdb" --size $room --quiet
record_views $engine engine-views 2
for p in 1 2 3 4 16 64; do
    count "$work/room.vdb" "paper-illuminate-$p" 2 $p
    count_views engine-views "paper-reconstruct-$p" $p
done
rm -f "$work"/*.vdb "$work/box.mha"

# Illumination of one recorded run in formats. Without interpolation it has no weights; a run with has.
light() { # NAME OPTIONS...
    $raysweep light "$work/cloud.vdb" -o "$work/lit.vdb" --extinction 8 --sun 0.3,0.2,-1,3 --sky 0.3 --dark-start \
        --sweeps $sweeps --tolerance 0 --beams 1 --record "$work/$1.json" --quiet "${@:2}"
}
replay_light() { # RECORD FORMAT
    for rounding in "${roundings[@]}"; do
        $cube4 illuminate --replay "$work/$1.json" --format "$2" --rounding "$rounding" --quiet \
            --report "$work/$1-$2-$rounding.json" >/dev/null
    done
}
$raysweep generate cloud -o "$work/cloud.vdb" --size $cloud --quiet
for zeta in "${zetas[@]}"; do
    light "light-$zeta" --zeta "$zeta"
    for bits in "${widths[@]}"; do replay_light "light-$zeta" "16,$bits,16,16,48"; done
done
light parts --zeta 0.1
light weights --zeta 0.1 --interpolation linear
for bits in "${widths[@]}"; do
    replay_light parts "16,24,$bits,16,48"
    replay_light weights "16,24,16,$bits,48"
done

# SART of a slice with inserts, and what is read of them: the slice is X-rayed along z, a voxel a pixel.
python3 bench/quality/cube4_phantom.py "$work"
replay_views() { # RECORD FORMAT ROUNDING
    local to="$work/$1-$2-$3"
    $cube4 reconstruct --replay "$work/$1.json" -o "$to.vdb" --format "$2" --rounding "$3" --pipelines 3 --quiet \
        --report "$to.json" >/dev/null
    $raysweep project "$to.vdb" -o "$to.mha" --geometry "$work/from_above.json" --quiet
    rm "$to.vdb"
}
for entry in "${relaxations[@]}"; do
    name=sart-${entry%:*}
    $raysweep ct "$work/scan.mha" -o "$work/found.vdb" --geometry "$work/scan.json" --size 64,64,1 --spacing 1 --nonnegative \
        --relaxation "${entry%:*}" --iterations "${entry#*:}" --support none --record "$work/$name.json" --quiet
    replay_views "$name" float nearest
    for rounding in "${roundings[@]}"; do
        for bits in "${voxelWidths[@]}"; do replay_views "$name" "$bits,24,24,24,48" "$rounding"; done
        [ "${entry%:*}" = 0.2 ] || continue
        for bits in "${widths[@]}"; do
            replay_views "$name" "24,$bits,24,24,48" "$rounding"
            replay_views "$name" "24,24,24,$bits,48" "$rounding"
        done
    done
done

python3 bench/quality/cube4_tables.py "$work" "$out" | tee "$out/tables.txt"
echo "tables: $out/tables.txt; pictures: cube4_scaling.svg, cube4_light.svg, cube4_sart.svg, cube4_contrast.svg beside it"
