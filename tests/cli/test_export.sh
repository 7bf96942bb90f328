# raysweep export: each grid moved by half a voxel of its own, values and metadata as they were.
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

finish
