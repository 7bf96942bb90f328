# raysweep export: for Blender each grid moved by half a voxel of its own, values and metadata as they were; for other programs
# the voxels of one grid, which come back to the bit, and where they were.
source "$(dirname "$0")/lib.sh" "$@"

"$make_volume" stretched plain.vdb
"$raysweep" light plain.vdb -o lit.vdb --extinction 0.1 --sky 1 --sweeps 20 --tolerance 0
expect_exit 0 "$raysweep" export lit.vdb -o moved.vdb --report report.json
expect_silent
expect_json report.json "r['grids'] == 3"
expect_exit 0 "$raysweep" info lit.vdb --json
cp .out lit.json
expect_exit 0 "$raysweep" info moved.vdb --json
cp .out moved.json
python3 - <<'PY' || fail "the grids are not where they should be"
import json
lit, moved = json.load(open("lit.json")), json.load(open("moved.json"))
assert "raysweep_export" in moved["metadata"]
assert [g["name"] for g in moved["grids"]] == ["density", "radiosity", "unshot"]
for a, b in zip(lit["grids"], moved["grids"]):
    assert a["bounds"]["index"] == b["bounds"]["index"] and a["min"] == b["min"] and a["max"] == b["max"]
    assert a["metadata"] == b["metadata"]
    m, n = a["transform"]["matrix"], b["transform"]["matrix"]
    assert m[:3] == n[:3]
    # Voxels of 0.1 x 0.2 x 0.05; row vectors, so the translation is the last row.
    assert all(abs(n[3][i] - (m[3][i] - d / 2)) < 1e-12 for i, d in enumerate((0.1, 0.2, 0.05)))
    assert [type(b["metadata"].get("raysweep_extinction", 0.1)), b["metadata"].get("raysweep_extinction", 0.1)] == [float, 0.1]
PY

# A copy for Blender is no volume to go on with.
for command in "export moved.vdb -o again.vdb" "render moved.vdb -o again.exr" "light moved.vdb -o again.vdb --sky 1"; do
    expect_exit 1 "$raysweep" $command
    expect_match "'moved.vdb' was written by raysweep export"
done
[ ! -e again.vdb ] && [ ! -e again.exr ] || fail "written in spite of the error"

# Points are no voxels, and a frustum has no voxel's edge to move by.
for kind in points frustum; do
    "$make_volume" $kind $kind.vdb
    expect_exit 0 "$raysweep" export $kind.vdb -o $kind-moved.vdb
    expect_match "grid 'density' is left where it is"
done

echo "the old file" >old.vdb
before=$(cksum old.vdb)
expect_exit 1 "$raysweep" export missing.vdb -o old.vdb
expect_match "cannot read 'missing.vdb'"
head -c 2000 lit.vdb >cut.vdb
expect_exit 1 "$raysweep" export cut.vdb -o old.vdb
expect_exit 2 "$raysweep" export lit.vdb
expect_exit 2 "$raysweep" export lit.vdb -o -
[ "$(cksum old.vdb)" = "$before" ] || fail "the old file was harmed"
expect_no_leftovers .

# For other programs. What comes back counts voxels from 0, so places are compared, and interpolation finds no difference.
"$make_volume" turned-cloud turned.vdb
"$make_volume" sheared sheared.vdb
"$make_volume" materials colours.vdb
for out in a.mha a.nrrd a.nii a.nii.gz a.tifs/; do
    expect_exit 0 "$raysweep" export turned.vdb -o $out --report report.json
    expect_silent
    expect_json report.json "r['grid'] == 'density' and all(abs(a - b) < 1e-12 for a, b in zip(r['spacing'], (.06, .04, .05)))"
    expect_exit 0 "$raysweep" import $out -o back.vdb --report back.json
    expect_silent
    expect_json back.json "r['type'] == 'float32' and r['dims'] == json.load(open('report.json'))['dims']"
    expect_json back.json "all(abs(a - b) < 1e-6 for a, b in zip(r['origin'], json.load(open('report.json'))['origin']))"
    expect_exit 0 "$raysweep" export back.vdb -o again.nrrd
    [ -e first.nrrd ] || "$raysweep" export turned.vdb -o first.nrrd
    cmp <(tail -c $((40 * 25 * 19 * 4)) first.nrrd) <(tail -c $((40 * 25 * 19 * 4)) again.nrrd) || fail "voxels of $out are others"
done
[ -e a.tifs/slice_0000.tif ] || fail "there are no slices"

# The same by ITK's eyes.
itk=$(dirname "$make_volume")/raysweep_itk_reader
if [ -x "$itk" ]; then
    for out in a.mha a.nrrd a.nii a.nii.gz; do
        expect_exit 0 "$itk" $out
        cp .out itk.json
        python3 - $out <<'PY' || fail "ITK finds another volume in $out"
import array, json, subprocess, sys
r, itk = json.load(open("report.json")), json.load(open("itk.json"))
assert itk["dims"] == r["dims"], itk["dims"]
near = 2e-6 if ".nii" in sys.argv[1] else 1e-14  # single precision of numbers up to 3; ITK makes its spacing of a quotient
data = open("first.nrrd", "rb").read()
samples = array.array("f", data[data.index(b"\n\n") + 2:])
assert array.array("f", itk["samples"]) == samples
header = dict(line.split(": ") for line in data[:data.index(b"\n\n")].decode().split("\n")[1:])
vector = lambda text: [float(n) for n in text.strip("()").split(",")]
wanted = [vector(v) for v in header["space directions"].split()] + [vector(header["space origin"])]
for a, b in zip(wanted, itk["steps"] + [itk["origin"]]):
    assert all(abs(x - y) <= near * max(1, abs(x)) for x, y in zip(a, b)), (a, b)
assert all(abs(x - y) < 1e-12 for x, y in zip(wanted[3], r["origin"]))
PY
    done
else
    echo "skipped: what ITK finds in the files; this build has none of it"
fi

# Sheared axes, colours, boxes.
expect_exit 1 "$raysweep" export sheared.vdb -o b.mha
expect_match "sheared"
for out in b.nrrd b.nii b; do
    expect_exit 0 "$raysweep" export sheared.vdb -o $out
    expect_exit 0 "$raysweep" import $out -o back.vdb
    expect_exit 0 "$raysweep" compare back.vdb sheared.vdb --max-rms 1e-6  # the voxels' numbers are the same: all are 1
done
expect_exit 1 "$raysweep" export colours.vdb -o c.mha --grid Cd
expect_match "'Cd' holds 3 channels, but a volume needs one number per voxel; choose one by --channel"
expect_exit 0 "$raysweep" export colours.vdb -o c.mha --grid Cd --channel 1 --dense-box -2,0,0,11,9,7 --report report.json
expect_json report.json "r['dims'] == [14, 10, 8] and r['corner'] == [-2, 0, 0]"
expect_exit 0 "$raysweep" import c.mha -o back.vdb --report back.json
expect_json back.json "r['voxels_active'] == 12 * 10 * 8 and [round(x, 6) for x in r['range']] == [0, 0.6]"
expect_exit 1 "$raysweep" export colours.vdb -o c.mha --grid nothing
expect_match "there is no grid called 'nothing'"
expect_exit 1 "$raysweep" export plain.vdb -o c.mha --dense-box 5,0,0,4,9,9
expect_match "--dense-box: 5 to 4 along i"
expect_exit 1 "$raysweep" export plain.vdb -o c.mha --dense-box 0,0,0,99999,9999,500000000
expect_match "GB; choose a smaller part by --dense-box"
"$make_volume" nan nan.vdb
expect_exit 1 "$raysweep" export nan.vdb -o nan.nrrd
expect_match "NaN or infinite at voxel (3, 4, 5)"
[ ! -e nan.nrrd ] || fail "written in spite of the error"

# Names: refused ones, folders, inputs.
expect_exit 2 "$raysweep" export plain.vdb -o c.xyz
expect_match "must end in .vdb, .mha, .nrrd, .nii, .nii.gz, or a folder"
expect_exit 2 "$raysweep" export plain.vdb -o d.vdb --grid density
expect_match "--grid: is for other files"
expect_exit 2 "$raysweep" export plain.vdb -o .
expect_match "holds 'plain.vdb'"
mkdir full && echo mine >full/notes.txt
expect_exit 1 "$raysweep" export plain.vdb -o full
expect_match "it holds 'notes.txt'"
expect_exit 1 "$raysweep" export moved.vdb -o again.mha
expect_match "'moved.vdb' was written by raysweep export"
expect_exit 1 bash -c "ulimit -f 16; exec '$raysweep' export turned.vdb -o limited.mha"
expect_match "cannot write 'limited.mha'"
expect_exit 1 bash -c "ulimit -f 1; exec '$raysweep' export turned.vdb -o limited/"
expect_match "cannot write 'limited/'"
[ ! -e limited.mha ] && [ ! -e limited ] || fail "written in spite of the error"
expect_no_leftovers .

finish
