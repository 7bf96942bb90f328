# examples/blender/import_lit.py: Cycles shows lit volumes as raysweep render does, and as the closed form says.
here=$(cd "$(dirname "$0")" && pwd)
source "$here/../cli/lib.sh" "$@"
script=$here/../../examples/blender/import_lit.py

if ! command -v blender >/dev/null; then
    echo "skipped: blender is not here (scripts/setup.sh --tests installs it)"
    exit 77
fi

# Blender ends with 0 whatever becomes of a script, unless told otherwise.
run() { expect_exit "$1" blender -b --python-exit-code 3 -P "${@:2}"; }
# in_blender OUT LIT.vdb OPTIONS...: the picture that Blender makes. 32 samples leave about 0.5 % of noise.
in_blender() {
    local out=$1 lit=$2
    shift 2
    run 0 "$script" -- "$lit" "$out" --raysweep "$raysweep" --samples 32 "$@"
    [ -s "$out" ] || fail "no picture $out"
}

names=()
# both NAME LIT.vdb CAMERA...: NAME.blender.exr and NAME.raysweep.exr, finely sampled.
both() {
    local name=$1 lit=$2
    shift 2
    in_blender "$name.blender.exr" "$lit" "$@"
    expect_exit 0 "$raysweep" render "$lit" -o "$name.raysweep.exr" --samples 3 --step 0.25 "$@"
    names+=("$name")
}

# What there is to show: clouds grey and coloured, on turned voxels of unequal edges, as half floats, and real smoke.
light() { expect_exit 0 "$raysweep" light "$@" --tolerance 0.03; }
grey=(--extinction 8 --sun 0.3,-1,-0.5,3 --sky 0.3)
coloured=(--extinction 8 --albedo 0.9,0.8,0.6 --sun 0.3,-1,-0.5,3:1:0.6:0.3 --sky 0.1,0.2,0.4)
"$raysweep" generate cloud -o cloud.vdb --size 40
"$make_volume" turned-cloud turned.vdb
light cloud.vdb -o grey.vdb "${grey[@]}"
light cloud.vdb -o coloured.vdb "${coloured[@]}"
light cloud.vdb -o half.vdb "${coloured[@]}" --half
light turned.vdb -o turned-lit.vdb "${grey[@]}"
light cloud.vdb -o coarse.vdb "${coloured[@]}" --resolution 0.4
light turned.vdb -o turned-coarse.vdb "${grey[@]}" --resolution 0.5 --half
# A solid: the file's own extinction and surfaces.
light cloud.vdb -o solid.vdb --ramp 0.1,0.6,0.5 --sun 0.3,-1,-0.5,3 --sky 0.3

view=(--size 96,96)
both grey grey.vdb "${view[@]}"
both coloured coloured.vdb "${view[@]}" --up 0,1,0 --fov 25
both half half.vdb "${view[@]}" --ortho 2.4
both solid solid.vdb "${view[@]}"
both turned turned-lit.vdb --size 120,80 --eye 4,-6,3 --target 3,-2,1 --fov 33
# Radiosity on longer voxels: the script has a copy made in which each grid is in its place.
both coarse coarse.vdb "${view[@]}"
both turned-coarse turned-coarse.vdb --size 120,80 --eye 4,-6,3 --target 3,-2,1 --fov 33
[ -z "$(ls *.blender.vdb 2>/dev/null)" ] || fail "the copy for Blender was left behind"
if [ -f "$data/vdb/smoke.vdb" ]; then
    light "$data/vdb/smoke.vdb" -o smoke.vdb --extinction 0.12 --sun 0.3,-1,0.2,3:1:0.7:0.4 --sky 0.3
    both smoke smoke.vdb "${view[@]}" --up 0,1,0 --fov 20
else
    echo "skipped: $data/vdb/smoke.vdb is not here"
fi

# A box of 12 x 10 x 8 voxels of 0.1 units, extinction 1, that emits: seen along y, optical depth 1 and radiance
# S (1 - 1/e), with S = emission / (4 pi extinction), here 1, and 3, 2, 1 where it glows in colours.
"$make_volume" materials box.vdb
pi=3.14159265358979
light box.vdb -o heat.vdb --albedo 0 --emission grid:heat --emission-scale $(python3 -c "print(2 * $pi)")
light box.vdb -o glow.vdb --albedo 0 --emission grid:glow --emission-scale $(python3 -c "print(4 * $pi)")
box=(--size 60,40 --ortho 1.5 --eye 0.55,-5,0.35 --target 0.55,0,0.35)
both heat heat.vdb "${box[@]}"
both glow glow.vdb "${box[@]}"

# Fire in smoke from 1e-6 to 1, which it shines through; on turned voxels half as long, partly beside the smoke, where the
# script has a copy made; and coloured, in an explosion that hides much of it.
for kind in fire turned-fire; do
    "$make_volume" $kind $kind.vdb
    light $kind.vdb -o $kind-lit.vdb --extinction 8 --fire fire --sky 0.1
    both $kind $kind-lit.vdb --size 96,96 --eye 4,-3,2 --target 0.7,0.45,0.35 --fov 25
done
"$raysweep" generate explosion -o explosion.vdb --size 64
light explosion.vdb -o explosion-lit.vdb --extinction 25 --albedo 0.7 --fire fire --sun 0.5,0.6,-1,1.5 --sky 0.05,0.07,0.1
both explosion explosion-lit.vdb --size 96,96
[ -z "$(ls *.blender.vdb 2>/dev/null)" ] || fail "the copy for Blender was left behind"

# Not moved back by half a voxel it must be seen to be off.
in_blender off.blender.exr grey.vdb "${view[@]}" --keep-half-voxel
cp grey.raysweep.exr off.raysweep.exr

run 0 "$here/compare_pictures.py" -- report.json "${names[@]}" off
grep % .out
for name in "${names[@]}"; do
    # The bias is what noise leaves of the mean of many pixels; a wrong factor anywhere would show there first.
    expect_json report.json "r['$name']['pixels'] > 300 and r['$name']['relative'] <= 0.02 and abs(r['$name']['bias']) <= 0.003"
done
expect_json report.json "r['off']['relative'] > 0.05"
# Closed form; 1e-3 is what the camera's rays through pixels of finite size and Cycles' random steps leave.
expect_json report.json "all(abs(a - b * (1 - math.exp(-1))) < 1e-3 for a, b in zip(r['heat']['middle'], (1, 1, 1, 1)))"
expect_json report.json "all(abs(a - b * (1 - math.exp(-1))) < 1e-3 for a, b in zip(r['glow']['middle'], (3, 2, 1, 1)))"

# A .png is the same bytes but for noise: exposure, background and the sRGB curve.
png=(--size 64,64 --exposure 0.7 --background 0.2,0.1,0.05)
in_blender shown.png coloured.vdb "${png[@]}"
expect_exit 0 "$raysweep" render coloured.vdb -o reference.png --samples 3 --step 0.25 "${png[@]}"
expect_exit 0 "$raysweep" compare shown.png reference.png --max-rms 0.004

# Without the command raysweep everything has to be said; then the picture is the same.
known=(--size 48,48 --eye -2,-5,2 --target 0,0,0)
in_blender with.png grey.vdb "${known[@]}"
run 0 "$script" -- grey.vdb without.png --raysweep /nowhere --samples 32 "${known[@]}" \
    --density density --extinction 8
expect_exit 0 "$raysweep" compare without.png with.png --max-rms 0

# What it refuses, and that it leaves nothing behind.
refuse() {
    local code=$1 text=$2
    shift 2
    run "$code" "$script" -- "$@"
    expect_match "$text"
}
refuse 2 "LIT.vdb"
refuse 2 "must end in .png or .exr" grey.vdb no.jpg
refuse 2 "--eye" grey.vdb no.png --eye 1,2
refuse 2 "--fov" grey.vdb no.png --fov 180
refuse 2 "--ortho" grey.vdb no.png --ortho 0
refuse 1 "there is no file 'missing.vdb'" missing.vdb no.png
refuse 1 "no grid 'radiosity': light it" cloud.vdb no.png --raysweep "$raysweep" --extinction 1
refuse 1 "no grid 'heat'" grey.vdb no.png --raysweep "$raysweep" --density heat
refuse 1 "cannot run '/nowhere'" grey.vdb no.png --raysweep /nowhere
refuse 1 "its folder does not exist" grey.vdb missing/no.png
refuse 1 "parallel" grey.vdb no.png --raysweep "$raysweep" --eye 0,0,5 --target 0,0,0
[ -z "$(ls no.* 2>/dev/null)" ] || fail "left behind: $(ls no.*)"
expect_no_leftovers .

finish
