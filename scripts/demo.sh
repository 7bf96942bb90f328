#!/usr/bin/env bash
# The main jobs from nothing: makes a cloud, lights it with sun and sky, and renders it with single scattering only and in
# full; X-rays a head, and reconstructs it from that. Usage: scripts/demo.sh [FOLDER [SIZE]]: pictures and volumes go to FOLDER (demo/); the cloud is SIZE (200) voxels long.
set -euo pipefail
[ $# -gt 0 ] && out=$(realpath -m "$1") || out=demo
size=${2:-200}
cd "$(dirname "$0")/.."

scripts/build.sh --target raysweep_app >/dev/null
raysweep=build/bin/raysweep
mkdir -p "$out"

light=(--extinction 40 --albedo 0.99 --sun 0.75,0.35,-0.6,4:1:0.9:0.75 --sky 0.16,0.24,0.4)
view=(--size 960,540 --eye=-1.2,-4.6,-0.15 --target 0,0,0.03 --fov 17 --background 0.10,0.20,0.42 --samples 2 --exposure=-0.4)

$raysweep generate cloud -o "$out/cloud.vdb" --size "$size" --seed 7
$raysweep light "$out/cloud.vdb" -o "$out/single.vdb" "${light[@]}" --sweeps 0
$raysweep light "$out/cloud.vdb" -o "$out/full.vdb" "${light[@]}" --plot "$out/convergence.png" --report "$out/full.json"
$raysweep render "$out/single.vdb" -o "$out/single.png" "${view[@]}"
$raysweep render "$out/full.vdb" -o "$out/full.png" "${view[@]}"

$raysweep generate shepp-logan -o "$out/head.vdb" --size 128
$raysweep project "$out/head.vdb" -o "$out/scan.mha" --parallel --views 90 --detector 192,128,0.015625
$raysweep ct "$out/scan.mha" -o "$out/reconstructed.vdb" --parallel --nonnegative --reference "$out/head.vdb" \
    --slices "$out/slices.png" --plot "$out/reconstruction.png"

echo "single scattering (sun): $out/single.png"
echo "full:                    $out/full.png"
echo "convergence:             $out/convergence.png"
echo "reconstructed slices:    $out/slices.png"
echo "their error by updates:  $out/reconstruction.png"
