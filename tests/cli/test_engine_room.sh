# raysweep generate engine-room: the paper's room around a block, an imported volume, or a level set.
source "$(dirname "$0")/lib.sh" "$@"

room="$raysweep generate engine-room"
describe() {
    expect_exit 0 "$raysweep" info "$1" --json
    cp .out info.json
}

# The block, in the paper's two sizes.
expect_exit 0 $room -o room.vdb --report room.json
expect_silent
expect_json room.json "r['dims'] == [276, 276, 130] and r['engine_dims'] == [256, 256, 110]"
describe room.vdb
expect_json info.json "[g['name'] for g in r['grids']] == ['density', 'emission']"
expect_json info.json "abs(r['grids'][0]['transform']['voxel_size'][0] - 2 / 276) < 1e-9"
expect_json info.json "0 < r['grids'][0]['min'][0] and r['grids'][0]['max'] == [1]"
# pi L over the lit area, in a layer one voxel thick.
expect_json room.json "abs(r['light_power'] / r['light_area'] - 3.14159265358979) < 1e-12"
expect_exit 0 $room -o small.vdb --size 148 --coloured --open-front --half --voxel-size 0.5 --report small.json
expect_json small.json "r['dims'] == [148, 148, 75]"
describe small.vdb
expect_json info.json "r['grids'][2]['name'] == 'albedo' and r['grids'][2]['type'] == 'vec3s'"
expect_json info.json "r['grids'][2]['active_voxels'] == r['grids'][0]['active_voxels']"
expect_json info.json "r['grids'][0]['transform']['voxel_size'] == [0.5, 0.5, 0.5]"
expect_exit 0 "$raysweep" info small.vdb
expect_output "--wall 4 --open-front --coloured"

# What light makes of it: all the light's power is injected.
expect_exit 0 $room -o tiny.vdb --size 60 --open-front --report tiny.json
expect_exit 0 "$raysweep" light tiny.vdb -o lit.vdb --ramp 0.2,1 --emission grid:emission --sweeps 20 --quiet --report lit.json
python3 -c "
import json
made, lit = (json.load(open(f)) for f in ('tiny.json', 'lit.json'))
assert abs(lit['power_injected'] / made['light_power'] - 1) < 1e-5, (lit['power_injected'], made['light_power'])" ||
    fail "the power injected is not the light's"

# Volumes: fog keeps its voxels, a level set becomes a solid.
expect_exit 0 "$raysweep" generate box -o box.vdb --dims 40,30,20 --density 0.5
expect_exit 0 $room --volume box.vdb -o around.vdb --report around.json
expect_json around.json "r['dims'] == [60, 50, 42] and r['voxels_active'] == 60*50*42 - 52*42*34 + 40*30*20"
expect_exit 0 $room --volume box.vdb -o around.vdb --wall 6 --crop-slices 5,14 --report around.json
expect_json around.json "r['dims'] == [64, 54, 34]"
expect_exit 0 $room --volume box.vdb -o around.vdb --size 40 --report around.json
expect_json around.json "r['dims'] == [40, 35, 31]"
expect_exit 0 "$raysweep" generate box -o dense.vdb --dims 40,30,20 --density 3
expect_exit 0 $room --volume dense.vdb -o around.vdb
expect_match "densities go up to 3"
expect_exit 0 "$make_volume" level-set level-set.vdb
expect_exit 0 $room --volume level-set.vdb -o around.vdb
describe around.vdb
expect_json info.json "r['grids'][0]['max'] == [1]"

engine=$data/volumes/engine.nrrd
if [ -f "$engine" ]; then
    expect_exit 0 "$raysweep" import "$engine" -o engine.vdb
    expect_exit 0 $room --volume engine.vdb -o room.vdb --report room.json
    expect_json room.json "r['dims'] == [276, 276, 130]"
    expect_exit 0 $room --volume engine.vdb -o room.vdb --size 148 --report room.json
    expect_json room.json "r['dims'] == [148, 148, 75]"
else
    echo "engine.nrrd is not on this machine: not tested with it"
fi

# Bad input.
expect_exit 1 $room --volume missing.vdb -o bad.vdb
expect_match "missing.vdb"
expect_exit 1 $room --volume box.vdb -o bad.vdb --size 100
expect_match "a room of at most 60"
expect_exit 1 $room --volume box.vdb -o bad.vdb --crop-slices 50,60
expect_match "slices 0 to 19"
expect_exit 1 $room --volume room.vdb --volume-grid walls -o bad.vdb
expect_match "no grid called 'walls'"
expect_exit 0 "$make_volume" empty empty.vdb
expect_exit 1 $room --volume empty.vdb -o bad.vdb
expect_match "is empty"
expect_exit 0 "$make_volume" negative negative.vdb
expect_exit 1 $room --volume negative.vdb -o bad.vdb
expect_match "are no densities; import it with --normalize, or --scale and --offset"
expect_exit 2 $room -o bad.vdb --size 20
expect_match "--size 20: must be in ["
expect_exit 2 $room -o bad.vdb --wall 1
expect_match "--wall 1: must be in [2,64]"
expect_exit 2 $room -o bad.vdb --crop-slices 5
expect_exit 2 $room -o bad.vdb --crop-slices 5,9
expect_match "--volume"
expect_exit 2 $room --volume box.vdb -o bad.vdb --voxel-size 2
expect_exit 2 $room -o bad.vdb --dims 1,2,3
expect_exit 2 "$raysweep" generate box -o bad.vdb --open-front
expect_match "engine-room"
[ ! -e bad.vdb ] || fail "an error wrote a file"
expect_no_leftovers .

finish
