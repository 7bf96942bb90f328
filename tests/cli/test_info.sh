# raysweep info and what it says of files that cannot be read.
source "$(dirname "$0")/lib.sh" "$@"

"$raysweep" generate sphere -o sphere.vdb --size 32 --soft 0
expect_exit 0 "$raysweep" info sphere.vdb
expect_output "density: float, fog volume"
expect_output "index box      (0, 0, 0) to (31, 31, 31)"
expect_output "world box      (-1, -1, -1) to (1, 1, 1)"
expect_output "raysweep_generate = sphere"
expect_silent

expect_exit 1 "$raysweep" info missing.vdb
expect_match "cannot read 'missing.vdb': there is no such file"
expect_exit 1 "$raysweep" info "$work"
expect_match "folder"
echo "plain text, long enough to hold a header" >text.vdb
expect_exit 1 "$raysweep" info text.vdb
expect_match "not an OpenVDB file"
: >empty.vdb
expect_exit 1 "$raysweep" info empty.vdb
expect_match "empty"
size=$(stat -c %s sphere.vdb)
for cut in 4 30 100 600 $((size / 2)) $((size - 1)); do
    head -c "$cut" sphere.vdb >cut.vdb
    expect_exit 1 "$raysweep" info cut.vdb
    expect_match "cut.vdb"
done
expect_match "grid 1 of 1 ('density'): the file ends inside it"
expect_exit 2 "$raysweep" info
expect_exit 2 "$raysweep" info sphere.vdb more.vdb

if [ -f "$data/vdb/smoke.vdb" ]; then
    expect_exit 0 "$raysweep" info "$data/vdb/smoke.vdb" --json
    cp .out smoke.json
    expect_json smoke.json "r['grids'][0]['active_voxels'] == 1049275 and r['grids'][0]['saved_as_half']"
    expect_json smoke.json "abs(r['grids'][0]['max'][0] - 5.71) < 0.01"
else
    echo "skipped: $data/vdb/smoke.vdb is not here"
fi

finish
