#!/usr/bin/env bash
# Figures 8 and 9 of Dachille, Mueller and Kaufman (2000): the engine, slices 9 to 118, reconstructed by SART from 100 parallel
# views in 1000 updates; RMS against updates, for exact, noisy and rounded projections. Usage:
# bench/quality/paper_ct.sh ENGINE.nrrd [FOLDER (bench/paper_ct)]
set -euo pipefail
[ $# -gt 0 ] || { sed -n 's/^# //p' "$0" >&2; exit 2; }
engine=$(realpath "$1")
out=$(realpath -m "${2:-$(dirname "$0")/../paper_ct}")
cd "$(dirname "$0")/../.."

scripts/build.sh --target raysweep_app >/dev/null
raysweep=build/bin/raysweep
mkdir -p "$out"

extinction=0.02 # per voxel of density 1: the largest line integral is then about that of a scan
$raysweep import "$engine" --crop 0,0,9,255,255,118 -o "$out/engine.vdb"

reconstruct() { # name, options of project
    local name=$1
    shift
    $raysweep project "$out/engine.vdb" -o "$out/$name.mha" --parallel --views 100 --detector 384,160,1 \
        --extinction $extinction --report "$out/$name-scan.json" "$@"
    $raysweep ct "$out/$name.mha" -o "$out/$name.vdb" --parallel --iterations 10 --nonnegative --scale 50 --history 10 \
        --reference "$out/engine.vdb" --size 256,256,110 --report "$out/$name.json" --slices "$out/$name.png"
    rm "$out/$name.mha"
}
reconstruct exact
reconstruct noise --photons 10000
reconstruct bits8 --bits 8
reconstruct bits12 --bits 12
reconstruct bits16 --bits 16

python3 - "$out" <<'EOF'
import json, subprocess, sys

out = sys.argv[1]
runs = [("exact", "exact"), ("bits16", "16 bits"), ("bits12", "12 bits"), ("bits8", "8 bits"), ("noise", "10000 photons a pixel")]
script = [f"set terminal pngcairo size 800,500\nset output '{out}/figure9.png'",
          "set xlabel 'updates'\nset ylabel 'RMS difference (engine: 0 to 1)'\nset logscale y\nset format y '%g'\nset grid"]
lines = []
for name, title in runs:
    report = json.load(open(f"{out}/{name}.json"))
    points = list(zip(report["updates_history"], report["rms_history"]))
    reached = next((u for u, rms in points if rms <= 0.09), None)
    print(f"{title:24} RMS {points[-1][1]:.4f} after {points[-1][0]} updates, at most 0.09 after {reached}; "
          f"{1000 * report['seconds_per_update']:.1f} ms an update")
    script.append(f"${name} << EOD\n" + "\n".join(f"{u} {rms}" for u, rms in points) + "\nEOD")
    lines.append(f"${name} with lines lw 2 title '{title}'")
script.append("plot " + ", ".join(lines) + ", 0.09 with lines dt 2 lc 'black' title 'the paper, after 1000'")
subprocess.run(["gnuplot"], input="\n".join(script), text=True, check=True)
EOF
view=(--size 640,480 --eye 400,-420,330 --target 127.5,127.5,60 --fov 26 --background 0,0,0)
for name in engine exact; do
    $raysweep light "$out/$name.vdb" -o "$out/$name-lit.vdb" --ramp 0.35,0.6 --albedo 0.9 --sun 0.4,0.8,-0.5,3 --sky 0.3
    $raysweep render "$out/$name-lit.vdb" -o "$out/figure8-$name.png" "${view[@]}"
done
echo "figure 8: $out/figure8-engine.png (original), $out/figure8-exact.png (reconstructed)"
echo "figure 9: $out/figure9.png"
