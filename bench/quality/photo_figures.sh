#!/usr/bin/env bash
# Figures 4, 10, 11 and 12 of Dachille, Mueller and Kaufman (2000), made again: translucent triangles, photographed from one
# ring and reconstructed in 1000 updates by the paper's method and by `consistent`. And what the paper does not have: how far
# off a direction of light is that was looked for, and views beside the truth that no reconstruction has seen.
# Usage: bench/quality/photo_figures.sh [FOLDER (bench/photo_figures)]; 18 minutes of processor time, and as long by the clock on
# two cores that had other work, too. SHORT=1: small, in 40 seconds, for whether it runs. RAYSWEEP=FILE: that program instead of a
# new build. docs/photographs.md says what is found.
set -euo pipefail
out=$(realpath -m "${1:-$(dirname "$0")/../photo_figures}")
cd "$(dirname "$0")/../.."

[ -n "${RAYSWEEP:-}" ] || scripts/build.sh --target raysweep_app >/dev/null
raysweep=${RAYSWEEP:-build/bin/raysweep}
size=128 lit=96 count=150 views=80 pixels=256 updates=1000 marks=10,100,300,1000 few=(12 6)
[ -z "${SHORT:-}" ] || { size=48 lit=48 count=40 views=16 pixels=96 updates=60 marks=10,20,30,60 few=(12 3); }
passes=$(((updates + views - 1) / views)) # photo counts these; tables are read at `updates`
early=$(((updates * 3 / 10 + views - 1) / views))
work=$out/work # volumes and reports
rm -rf "$work"
mkdir -p "$work"

shoot() { # VOLUME FOLDER OPTIONS...: floats, so that nothing but the method is at fault
    $raysweep shoot "$1" -o "$2" --views $views --size $pixels,$pixels --ortho auto --format exr --quiet "${@:3}"
}
reconstruct() { # PHOTOGRAPHS NAME METHOD PASSES OPTIONS...: all voxels of the cube are compared
    $raysweep photo "$1" -o "$work/$2.vdb" --method "$3" --iterations "$4" --relaxation 1 --seed 1 --bounds=-1,-1,-1,1,1,1 \
        --reference "$work/triangles.vdb" --history 10 --report "$work/$2.json" --quiet "${@:5}"
}
picture() { # VOLUME PICTURE OPTIONS...
    $raysweep render "$1" -o "$2" --size $pixels,$pixels --background 1 --quiet "${@:3}"
}
beside() { # COLUMNSxROWS PICTURE PICTURES...
    local raster=$1 to=$2
    shift 2
    oiiotool "$@" --mosaic:pad=4 "$raster" --ch R,G,B -o "$to"
}

# Figure 4: voxels filled in part, and voxels that are full or empty.
$raysweep generate triangles -o "$work/triangles.vdb" --size $size --count $count --seed 1 --report "$work/triangles.json"
$raysweep generate triangles -o "$work/binary.vdb" --size $size --count $count --seed 1 --binary --report "$work/binary.json"
near=(--eye 0,-4,2 --target 0,0,0 --ortho 0.8)
picture "$work/triangles.vdb" "$work/figure4_soft.png" "${near[@]}"
picture "$work/binary.vdb" "$work/figure4_binary.png" "${near[@]}"
beside 2x1 "$out/figure4.png" "$work/figure4_soft.png" "$work/figure4_binary.png"
$raysweep compare "$work/binary.vdb" "$work/triangles.vdb" --grid opacity >"$out/figure4.txt"

# Figure 11: RMS by updates, of 80 parallel views of one ring before white and black.
shoot "$work/triangles.vdb" "$work/ring" --backdrop white,black
for method in paper consistent; do
    reconstruct "$work/ring" $method $method $passes
    reconstruct "$work/ring" $method-early $method $early
    reconstruct "$work/ring" $method-pass $method 1
done

# Figure 10: the original, and what there is after some updates, from between two photographs and from above all of them.
whole=(--target 0,0,0 --ortho 2.6)
for place in ring:0.157,-4,0 above:1.5,-3,2.6; do
    name=${place%%:*} eye=(--eye "${place#*:}")
    for volume in triangles {paper,consistent}{-pass,-early,}; do
        picture "$work/$volume.vdb" "$work/figure10_${name}_$volume.png" "${eye[@]}" "${whole[@]}"
        [ $volume = triangles ] || echo "$name $volume $($raysweep compare "$work/figure10_${name}_$volume.png" \
            "$work/figure10_${name}_triangles.png" | awk '$1 == "psnr" || $1 == "ssim" { printf "%s %s ", $1, $2 }')"
    done
    of=("$work/figure10_${name}_"{triangles,paper-pass,paper-early,paper,triangles,consistent-pass,consistent-early,consistent}.png)
    beside 4x2 "$out/figure10_$name.png" "${of[@]}"
done >"$out/figure10.txt"

# Figure 12: light that is known, as more and more of it is diffuse; figure 11 is without.
light=0.6,1,-0.5
for method in paper consistent; do cp "$work/$method-early.json" "$work/share-$method-0.json"; done
for share in 0.25 0.5 0.75 1; do
    lamp=(--diffuse $share --light $light)
    shoot "$work/triangles.vdb" "$work/lit" --backdrop white,black "${lamp[@]}"
    for method in paper consistent; do reconstruct "$work/lit" share-$method-$share $method $early "${lamp[@]}"; done
done

# The light, looked for in a volume of 96 voxels, which is as fine as that goes. A ring says less of how high it stands than a sphere.
$raysweep generate triangles -o "$work/few.vdb" --size $size --count "${few[0]}" --thickness "${few[1]}" --seed 1
for place in "triangles ring" "triangles sphere" "few ring" "few sphere"; do
    read -r scene orbit <<<"$place"
    for share in 0.25 0.5 0.75 1; do
        name=light-$scene-$orbit-$share
        shoot "$work/$scene.vdb" "$work/lit" --orbit $orbit --diffuse $share --light $light
        $raysweep photo "$work/lit" -o "$work/lit.vdb" --method consistent --light auto --iterations 1 --size $lit --quiet \
            --report "$work/$name.json"
        cp "$work/lit/rig.json" "$work/$name-rig.json"
        cp "$work/lit/transforms.json" "$work/$name-transforms.json"
    done
done

# A view that was held out: photograph, render, and twice the difference; without what is empty around the object.
$raysweep generate triangles -o "$work/sheets.vdb" --size $size --count 50 --thickness "${few[1]}" --seed 2
$raysweep shoot "$work/sheets.vdb" -o "$work/lit" --views $views --orbit sphere --size $pixels,$pixels --quiet
$raysweep photo "$work/lit" -o "$work/held_out.vdb" --hold-out 8 --size $size --compare-views "$work/views" --quiet \
    --report "$work/held_out.json"
shown=("$work"/views/*_held_out.png)
edge=$((pixels * 3 / 4)) from=$((pixels / 8)) parts=()
for part in 0 1 2; do parts+=("${shown[${#shown[@]} / 3]}" --cut ${edge}x$edge+$((part * pixels + from))+$from); done
oiiotool "${parts[@]}" --mosaic:pad=4 3x1 --ch R,G,B --compression jpeg:88 -o "$out/held_out.jpg"

rm -r "$work/ring" "$work/lit" "$work/lit.vdb" "$work/views"
python3 bench/quality/photo_tables.py "$work" "$out" --marks $marks | tee "$out/tables.txt"
echo "tables: $out/tables.txt, figure11.csv, figure12.csv, light.csv, figure4.txt and figure10.txt beside it"
echo "pictures: $out/figure4.png, figure10_ring.png, figure10_above.png, figure11.svg, figure12.svg, held_out.jpg beside it"
