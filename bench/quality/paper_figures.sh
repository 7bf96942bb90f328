#!/usr/bin/env bash
# Figures 2, 3, 6 and 7 of Dachille, Mueller and Kaufman 2000, made again: an engine in a room with half a ceiling of light.
# Usage: bench/quality/paper_figures.sh [FOLDER [ENGINE]]; pictures go to FOLDER (paper_figures/). ENGINE is a volume that
# `raysweep import` reads, such as the scan of the engine that the paper used; without one a made-up block stands in.
set -euo pipefail
[ $# -gt 0 ] && out=$(realpath -m "$1") || out=paper_figures
[ $# -gt 1 ] && engine=$(realpath "$2") || engine=""
cd "$(dirname "$0")/../.."

scripts/build.sh --target raysweep_app >/dev/null
raysweep=build/bin/raysweep
mkdir -p "$out"
value() { python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))[sys.argv[2]])' "$1" "$2"; }

room=(generate engine-room --open-front)
if [ -n "$engine" ]; then
    $raysweep import "$engine" -o "$out/engine.vdb"
    room+=(--volume "$out/engine.vdb")
    camera=(--eye 127,-230,75 --target 127,120,58)  # the scan has its corner at the origin
else
    room+=(--voxel-size 1)
    camera=(--eye 0,-357,15 --target 0,-7,-2)  # the room has its middle there
fi
$raysweep "${room[@]}" -o "$out/room.vdb"
light=(--ramp 0.2,1 --emission grid:emission --albedo 0.9)
view=(--size 900,480 "${camera[@]}" --fov 38 --samples 2)
bright=(--exposure 0.3)

# Figure 2: the convergence.
$raysweep light "$out/room.vdb" -o "$out/full.vdb" "${light[@]}" --sweeps 1000 --tolerance 0 \
    --plot "$out/figure2_convergence.png" --report "$out/full.json"
$raysweep render "$out/full.vdb" -o "$out/figure3_converged.png" "${view[@]}" "${bright[@]}"

# Figure 3: after the first sweeps, with what is still unshot in red, and when it has converged.
$raysweep light "$out/room.vdb" -o "$out/initial.vdb" "${light[@]}" --sweeps 20 --tolerance 0 --remaining drop
$raysweep render "$out/initial.vdb" -o "$out/figure3_initial.png" "${view[@]}" "${bright[@]}" --unshot 1,0.05,0.05

# Figure 6: solved on voxels twice as long.
$raysweep light "$out/room.vdb" -o "$out/coarse.vdb" "${light[@]}" --sweeps 1000 --tolerance 0 --resolution 0.5 \
    --report "$out/coarse.json"
$raysweep render "$out/coarse.vdb" -o "$out/figure6_low_resolution.png" "${view[@]}" "${bright[@]}"
cp "$out/figure3_converged.png" "$out/figure6_high_resolution.png"
$raysweep compare "$out/full.vdb" "$out/coarse.vdb" --grid radiosity >"$out/figure6_difference.txt"

# Figure 7: light that was scattered once. With an albedo of 1e-3 hardly any is scattered twice; 0.9/1e-3 times as bright
# (9.81 stops) it is what single scattering makes of an albedo of 0.9.
$raysweep light "$out/room.vdb" -o "$out/single.vdb" --ramp 0.2,1 --emission grid:emission --albedo 0.001 --sweeps 1000 \
    --tolerance 0
$raysweep render "$out/single.vdb" -o "$out/figure7_single.png" "${view[@]}" --exposure 10.11
cp "$out/figure3_converged.png" "$out/figure7_multiple.png"

echo "seconds per sweep: $(value "$out/full.json" seconds_per_sweep); all of it: $(value "$out/full.json" seconds) s"
python3 - "$out/full.json" <<'PYTHON'
import json, sys
report = json.load(open(sys.argv[1]))
print("unshot at the end: %.3g %% of the power" % (100 * report["power_unshot"] / report["power_injected"]))
PYTHON
echo "low against high resolution: $(tr '\n' ' ' <"$out/figure6_difference.txt")"
echo "pictures: $out/figure*.png"
