# raysweep light --resolution: solved on longer voxels, rendered with the density as it is.
source "$(dirname "$0")/lib.sh" "$@"

"$raysweep" generate cloud -o cloud.vdb --size 48
light() { expect_exit 0 "$raysweep" light "$@" --report report.json; }
lights=(--extinction 6 --sun 0.3,-1,-0.5,3:1:0.8:0.6 --sky 0.2,0.3,0.4 --tolerance 0.005)
light cloud.vdb -o full.vdb "${lights[@]}"
expect_json report.json "r['resolution'] == 1 and not any('resolution' in line for line in r['plan'])"
cp report.json full.json
light cloud.vdb -o one.vdb "${lights[@]}" --resolution 1
expect_exit 0 "$raysweep" compare one.vdb full.vdb --grid radiosity --max-rms 0

light cloud.vdb -o half.vdb "${lights[@]}" --resolution 0.5
expect_silent
expect_json report.json "r['resolution'] == 0.5 and r['balance_error'] < 1e-5"
expect_json report.json "'resolution 0.5: solved on voxels 2 times as long, %d instead of' % r['voxels_active'] in r['plan'][-1]"
active=$(json report.json "r['voxels_active']")
expect_json full.json "r['voxels_active'] / 10 < $active < r['voxels_active'] / 4"
expect_exit 0 "$raysweep" info half.vdb --json
cp .out half.json
grid() { echo "next(g for g in r['grids'] if g['name'] == '$1')"; }
edge() { echo "$(grid "$1")['transform']['voxel_size'][0]"; }
expect_json half.json "abs($(edge radiosity) / $(edge density) - 2) < 1e-12"
expect_json half.json "$(grid radiosity)['metadata']['raysweep_resolution'] == 0.5"
expect_exit 0 "$raysweep" compare half.vdb cloud.vdb --max-rms 0

# The picture is close, and that of radiosity interpolated beforehand is the same but for being interpolated twice.
render() { expect_exit 0 "$raysweep" render "$1.vdb" -o "$1.exr" --size 64,64; }
light cloud.vdb -o up.vdb "${lights[@]}" --resolution 0.5 --upsample
expect_exit 0 "$raysweep" info up.vdb --json
cp .out up.json
expect_json up.json "abs($(edge radiosity) / $(edge density) - 1) < 1e-12"
for name in full half up; do render $name; done
expect_exit 0 "$raysweep" compare half.exr full.exr --max-rms 0.01
expect_exit 1 "$raysweep" compare half.exr full.exr --max-rms 1e-5
expect_match "is above --max-rms"
expect_exit 0 "$raysweep" compare up.exr half.exr --max-rms 0.001
expect_exit 0 "$raysweep" compare half.vdb up.vdb --grid radiosity --max-rms 1e-6
expect_output "resampled      half.vdb onto the voxels of up.vdb"

# Not whole, very coarse, with grids for albedo and emission, as snapshots, and on voxels that are no cubes.
light cloud.vdb -o odd.vdb "${lights[@]}" --resolution 0.7
light cloud.vdb -o odd.vdb "${lights[@]}" --resolution 0.001
"$make_volume" materials materials.vdb
light materials.vdb -o odd.vdb --albedo grid:Cd --emission grid:glow --resolution 0.3
expect_json report.json "abs(r['power_injected'] / (2 * 12 * 10 * 8 * 1e-3) - 1) < 1e-5"
light cloud.vdb -o snap.vdb --sky 1 --resolution 0.5 --upsample --sweeps 20 --tolerance 0 --snapshots 20
expect_exit 0 "$raysweep" compare snap_0020.vdb snap.vdb --grid radiosity --max-rms 0.1
grep -q resampled .out && fail "the snapshot was not interpolated as the answer was"
"$make_volume" sheared sheared.vdb
light sheared.vdb -o odd.vdb --sky 1 --resolution 0.6 --sweeps 40
"$make_volume" empty empty.vdb
light empty.vdb -o odd.vdb --sky 1 --resolution 0.5

expect_exit 0 "$raysweep" light cloud.vdb "${lights[@]}" --resolution 0.25 --upsample --explain
expect_output "resolution 0.25: solved on voxels 4 times as long"
expect_output "interpolated to the voxels of the input"

# What it refuses; voxels are named as they are in the input.
for bad in 0 -0.5 1.5 nan many; do
    expect_exit 2 "$raysweep" light cloud.vdb -o no.vdb --resolution $bad
    expect_match "--resolution"
done
"$make_volume" negative negative.vdb
expect_exit 1 "$raysweep" light negative.vdb -o no.vdb --sky 1 --resolution 0.5
expect_match "the first at index (3, 4, 5)"
"$make_volume" frustum frustum.vdb
expect_exit 1 "$raysweep" light frustum.vdb -o no.vdb --sky 1 --resolution 0.5
expect_match "not linear"
[ ! -e no.vdb ] || fail "written in spite of the error"

finish
