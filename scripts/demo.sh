#!/usr/bin/env bash
# The main jobs from nothing: makes a cloud, lights it with sun and sky, and renders it with single scattering only and in
# full; X-rays a head, and reconstructs it from that; photographs coloured sheets, makes a volume of the photographs, and lights
# it anew. Usage: scripts/demo.sh [FOLDER [SIZE]]: pictures and volumes go to FOLDER (demo/); the cloud is SIZE (200) voxels long.
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

$raysweep generate triangles -o "$out/sheets.vdb" --size 128 --count 50 --thickness 6 --seed 2
$raysweep shoot "$out/sheets.vdb" -o "$out/photographs" --views 48 --orbit sphere --size 240,240
$raysweep photo "$out/photographs" -o "$out/photographed.vdb" --hold-out 8 --size 128 --iterations 3 --report "$out/photo.json"
$raysweep light "$out/photographed.vdb" -o "$out/relit.vdb" --albedo grid:Cd --sun 0.8,0.45,-0.3,4:1:0.75:0.5 --sky 0.25,0.32,0.45
elsewhere=(--size 360,360 --eye 2.2,-4,1.5 --target 0,0,-0.08 --fov 27)
$raysweep render "$out/photographed.vdb" -o "$out/photographed.png" "${elsewhere[@]}" --background 1
$raysweep render "$out/relit.vdb" -o "$out/relit.png" "${elsewhere[@]}" --background 0.25,0.32,0.45

# Nine photographs, the view from elsewhere and the new light beside each other: docs/images/photographs.jpg.
photographs=()
for view in 03 09 14 18 24 29 34 39 45; do photographs+=("$out/photographs/view_00$view.png" --cut 144x144+48+48); done
oiiotool "${photographs[@]}" --mosaic 3x3 --resize 360x360 --pattern constant:color=1,1,1,1 360x360 4 --over --ch R,G,B \
    "$out/photographed.png" "$out/relit.png" --mosaic:pad=4 3x1 --compression jpeg:85 -o "$out/photographs.jpg"

echo "single scattering (sun): $out/single.png"
echo "full:                    $out/full.png"
echo "convergence:             $out/convergence.png"
echo "reconstructed slices:    $out/slices.png"
echo "their error by updates:  $out/reconstruction.png"
echo "from photographs:        $out/photographs.jpg"
