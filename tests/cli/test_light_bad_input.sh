# raysweep light on what it cannot work with: a message that says what, where and what to do, exit 1 or 2, and no file.
source "$(dirname "$0")/lib.sh" "$@"

"$raysweep" generate cloud -o cloud.vdb --size 32
make() { "$make_volume" "$1" "$1.vdb"; }
# refuse CODE TEXT ARGUMENTS...: fails with TEXT and leaves the file that was there as it was.
echo "the old file" >lit.vdb
before=$(cksum lit.vdb)
refuse() {
    local code=$1 text=$2
    shift 2
    expect_exit "$code" "$raysweep" light "$@"
    expect_match "$text"
    [ "$(cksum lit.vdb)" = "$before" ] || fail "the old file was harmed by $*"
    expect_no_leftovers .
}
to=(--sky 1 -o lit.vdb)

# Files.
refuse 1 "cannot read 'missing.vdb': there is no such file" missing.vdb "${to[@]}"
refuse 1 "folder" . "${to[@]}"
echo "plain text, long enough to hold a header" >text.vdb
refuse 1 "not an OpenVDB file" text.vdb "${to[@]}"
size=$(stat -c %s cloud.vdb)
for cut in 0 20 200 $((size / 2)) $((size - 1)); do
    head -c "$cut" cloud.vdb >cut.vdb
    refuse 1 "cut.vdb" cut.vdb "${to[@]}"
done

# Grids: every message lists what there is.
make no-grid && refuse 1 "It holds no grids" no-grid.vdb "${to[@]}"
make no-float && refuse 1 "there is no grid of float. It holds:" no-float.vdb "${to[@]}"
expect_match "ids: int32"
make two-floats && refuse 1 "say by name which to use" two-floats.vdb "${to[@]}"
expect_match "--density"
expect_match "fuel: float"
refuse 1 "there is no grid called 'heat'" two-floats.vdb "${to[@]}" --density heat
expect_exit 0 "$raysweep" light two-floats.vdb --sky 1 -o ok.vdb --density fuel --sweeps 40
make only-float
expect_exit 0 "$raysweep" light only-float.vdb --sky 1 -o ok.vdb --sweeps 40
make same-name && refuse 1 "'density[1]' the second" same-name.vdb "${to[@]}"
expect_exit 0 "$raysweep" light same-name.vdb --sky 1 -o ok.vdb --density 'density[1]' --sweeps 40
make points && refuse 1 "holds points, not a volume; rasterize them first" points.vdb "${to[@]}"
three=$data/vdb/grids_test2315.vdb
if [ -f "$three" ]; then
    refuse 1 "3 grids are called 'density'" "$three" "${to[@]}"
    expect_exit 0 "$raysweep" light "$three" --sky 1 -o ok.vdb --density 'density[2]' --report report.json
    expect_json report.json "r['voxels_active'] == 803 and r['balance_error'] <= 1e-5"
    for n in 0 1 2; do expect_exit 0 "$raysweep" compare "$three" ok.vdb --grid "density[$n]" --max-rms 0; done
    # The picture is of the one that was lit.
    expect_exit 0 "$raysweep" render ok.vdb -o ok.png --size 16,16
else
    echo "skipped: $three is not here"
fi

# A level set is no density; its inside is.
make level-set && refuse 1 "is a level set" level-set.vdb "${to[@]}"
expect_match "not densities; use --from-level-set to fill its inside with density 1, or convert it first (Houdini"
expect_exit 0 "$raysweep" light level-set.vdb --from-level-set --sky 1 -o ok.vdb --report report.json
expect_json report.json "r['balance_error'] <= 1e-5 and r['power_absorbed'] > 0"
refuse 1 "is not a level set; leave out --from-level-set. It holds" cloud.vdb --from-level-set "${to[@]}"

# Values.
for kind in nan infinite negative; do
    make $kind && refuse 1 "the first at index (3, 4, 5), world (0.3, 0.4, 0.5)" $kind.vdb "${to[@]}"
    expect_match "; repair the file, or use --repair to set such voxels to 0"
    expect_exit 0 "$raysweep" light $kind.vdb --repair --sky 1 -o ok.vdb --report report.json
    expect_match "1 voxel of 'density' was NaN, infinite or negative and counts as 0"
    expect_json report.json "r['balance_error'] <= 1e-5"
    # The copy of the input in the output is as it was.
    expect_exit 1 "$raysweep" light ok.vdb -o again.vdb --sky 1
done
make materials && refuse 1 "albedo: 960 active voxels are outside [0,1]" materials.vdb --albedo grid:too-white "${to[@]}"
refuse 1 "--g: the albedo grid 'Cd' is of type vec3s" materials.vdb --albedo grid:Cd --g 0.5 "${to[@]}"
refuse 1 "--g: albedo: 960 active voxels are outside [0,1]" materials.vdb --albedo grid:too-white --g 0.5 "${to[@]}"
refuse 1 "--albedo: 'materials.vdb': there is no grid called 'cd'" materials.vdb --albedo grid:cd "${to[@]}"
refuse 1 "--emission: 'materials.vdb': there is no grid called 'fire'" materials.vdb --emission grid:fire "${to[@]}"

# Voxels of any parallelepiped work; frustums do not.
for kind in stretched sheared; do
    make $kind
    expect_exit 0 "$raysweep" light $kind.vdb --albedo 1 --sky 1 --extinction 5 --tolerance 0.003 -o ok.vdb --report report.json
    expect_json report.json "r['balance_error'] <= 1e-5"
    expect_exit 0 "$raysweep" render ok.vdb --background 1 -o ok.exr --size 24,24 --report picture.json
    expect_json picture.json "abs(r['mean'][0] - 1) < 5e-3"
done
make frustum && refuse 1 "not linear" frustum.vdb "${to[@]}"

# Nothing at all, one tile, and whole leaves that are active but empty: no voxel may be left without a value.
make empty
expect_exit 0 "$raysweep" light empty.vdb -o ok.vdb --sky 1
expect_match "nothing to light"
for kind in tile empty-leaves; do
    make $kind
    expect_exit 0 "$raysweep" light $kind.vdb -o ok.vdb --extinction 5 --sky 1
    "$raysweep" info ok.vdb --json >info.json
    expect_json info.json "all(g['not_finite'] == 0 for g in r['grids'])"
    expect_json info.json "all(g['active_tiles'] == 0 for g in r['grids'] if g['name'] != 'density')"
done

# What was typed: refused before anything is read, so the missing file is not what is complained about.
usage() {
    local text=$1
    shift
    refuse 2 "$text" missing.vdb -o lit.vdb "$@"
    expect_match "--help"
}
usage "--sun: '0,0,0': the direction has no length" --sun 0,0,0,3
usage "--sun: '0,0,1': four values are needed" --sun 0,0,1
usage "'x' in '0,x,1' is not a number; for example --sun 0.3,-1,0.2,3" --sun 0,x,1,1
usage "light cannot be negative" --sun 0,0,-1,-3
usage "one number or E:R:G:B is needed" --sun 0,0,-1,3:1
usage "--sun" --sun 0,0,nan,1
usage "--point" --point 0,0,1
usage "--point: '-1': light cannot be negative" --point 0,0,1,-1
usage "--sky: '-1'" --sky -1
usage "--sky" --sky bright
usage "--sky-scale" --sky 1 --sky-scale -1
usage "--albedo 1.2: must be in [0, 1]" --albedo 1.2
usage "--albedo" --albedo -0.1
usage "--albedo" --albedo 0.5,0.6
usage "--albedo" --albedo nan
usage "--albedo: 'grid:'" --albedo grid:
usage "--g 1: must be in (-1, 1)" --g 1
usage "--g -1.5: must be in (-1, 1)" --g -1.5
usage "--g" --g nan
usage "--g: needs a grey albedo" --g 0.5 --albedo 0.9,0.8,0.7
usage "--emission: 'heat': grid:NAME is needed" --emission heat
usage "--emission-scale inf: must be finite" --emission-scale inf
usage "--extinction -1: must be finite and not negative" --extinction -1
usage "--extinction" --extinction nan
usage "--extinction" --extinction thick
usage "--tolerance -1: must be 0 or more" --tolerance -1
usage "sweeps" --sweeps -3
usage "sweeps" --sweeps 1.5
usage "--zeta 0: must be in (0, 1]" --zeta 0
usage "zeta" --zeta 1.5
usage "--interpolation" --interpolation cubic
usage "--exchange" --exchange magic
usage "--remaining" --remaining lose
usage "--quality" --quality best
usage "'x.pdf' must end in .svg or .png" --plot x.pdf
usage "--frobnicate" --frobnicate
refuse 2 "input" -o lit.vdb
refuse 2 "--output: a file name is needed" cloud.vdb
refuse 2 "standard output cannot be used" cloud.vdb -o -

# Where the answer cannot be written: said before the work.
refuse 1 "the folder 'missing' does not exist; create it first" cloud.vdb --sky 1 -o missing/lit.vdb
refuse 1 "cannot write 'missing/r.json'" cloud.vdb "${to[@]}" --report missing/r.json
refuse 1 "cannot write 'missing/p.svg'" cloud.vdb "${to[@]}" --plot missing/p.svg
refuse 1 "it names a folder" cloud.vdb --sky 1 -o .
mkdir readonly && chmod a=rx readonly
as_user=()
[ "$(id -u)" = 0 ] && as_user=(setpriv --reuid=65534 --regid=65534 --clear-groups)
if "${as_user[@]}" "$raysweep" --version >/dev/null 2>&1; then
    expect_exit 1 "${as_user[@]}" "$raysweep" light cloud.vdb --sky 1 -o "$work/readonly/lit.vdb"
    expect_match "no permission to write in the folder"
else
    echo "skipped: read-only folder, root may write anywhere and cannot become somebody else here"
fi

# A full disk: a limit on the size of files stands for it, and a small file system where one can be had.
expect_exit 1 bash -c "ulimit -f 16; exec '$raysweep' light cloud.vdb --sky 1 -o lit.vdb"
expect_match "cannot write 'lit.vdb'"
[ "$(cksum lit.vdb)" = "$before" ] || fail "the old file was harmed"
expect_no_leftovers .
mkdir full
if mount -t tmpfs -o size=64k tmpfs full 2>/dev/null; then
    trap 'umount "$work/full"' EXIT
    expect_exit 1 "$raysweep" light cloud.vdb --sky 1 -o full/lit.vdb
    expect_match "No space left"
    expect_no_leftovers full
    [ ! -e full/lit.vdb ] || fail "a partial file appeared"
else
    echo "skipped: full disk, no permission to mount one"
fi

finish
