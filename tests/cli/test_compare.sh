# raysweep compare: numbers, the limit, and the choice of a grid.
source "$(dirname "$0")/lib.sh" "$@"

"$raysweep" generate box -o one.vdb --size 16
"$raysweep" generate box -o half.vdb --size 16 --density 0.5
"$raysweep" generate box -o large.vdb --size 17

expect_exit 0 "$raysweep" compare one.vdb one.vdb --max-rms 0
expect_output "psnr           infinite"
expect_exit 0 "$raysweep" compare half.vdb one.vdb --json --report report.json
cmp -s .out report.json || fail "the report is not what was printed"
expect_json report.json "r['rmse'] == 0.5 and r['relative_rmse'] == 0.5 and r['max'] == 0.5 and r['voxels'] == 4096"
expect_json report.json "abs(r['psnr'] - 6.0206) < 1e-3"
expect_exit 0 "$raysweep" compare half.vdb one.vdb --max-rms 0.5
expect_exit 1 "$raysweep" compare half.vdb one.vdb --max-rms 0.49
expect_match "--max-rms"
expect_output "rmse           0.5"

# Voxels that do not coincide: the coarser grid is interpolated at the voxels of the finer, whichever comes first.
expect_exit 0 "$raysweep" compare one.vdb large.vdb --report report.json
expect_output "resampled      one.vdb onto the voxels of large.vdb"
expect_json report.json "r['voxels'] == 17**3 and 0 < r['max'] < 1"
expect_exit 0 "$raysweep" compare large.vdb one.vdb --report report.json
expect_output "resampled      one.vdb onto the voxels of large.vdb"
expect_json report.json "r['voxels'] == 17**3"
expect_exit 1 "$raysweep" compare one.vdb half.vdb --grid heat
expect_match "no grid called 'heat'"
expect_match "density: float, fog volume, 4096 active voxels"
expect_exit 1 "$raysweep" compare one.vdb missing.vdb
expect_exit 2 "$raysweep" compare one.vdb
expect_exit 2 "$raysweep" compare one.vdb image.exr
expect_exit 2 "$raysweep" compare one.vdb half.vdb --max-rms -1

three=$data/vdb/grids_test2315.vdb
if [ -f "$three" ]; then
    expect_exit 1 "$raysweep" compare "$three" "$three"
    expect_match "3 grids are called 'density'; 'density[0]' picks the first, 'density[1]' the second"
    expect_match "density[2]: float"
    expect_exit 0 "$raysweep" compare "$three" "$three" --grid 'density[2]' --max-rms 0
    expect_exit 1 "$raysweep" compare "$three" "$three" --grid 'density[3]'
    expect_match "no grid called 'density[3]'"
else
    echo "skipped: $three is not here"
fi

finish
