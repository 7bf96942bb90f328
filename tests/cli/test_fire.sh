# Fire: what shines by itself is written, shown, recorded and exported apart from radiosity.
source "$(dirname "$0")/lib.sh" "$@"
cube4="$(dirname "$raysweep")/raysweep-cube4"

light() { expect_exit 0 "$raysweep" light "$@" --report report.json; }
info() { "$raysweep" info "$1" --json >info.json; }
grids="{g['name']: g for g in r['grids']}"
same_grid() { expect_exit 0 "$raysweep" compare "$1" "$2" --grid "$3" --max-rms 0; }

for kind in fire turned-fire fire-beside no-fire nan-fire; do "$make_volume" $kind $kind.vdb; done

# Smoke from 1e-6 to 1, so thin that it hides nothing: the mean of the picture is the power over 4 pi and the picture's
# area, from all sides, whatever the voxels of the fire.
power=$(python3 -c "print((24 * 0.05) ** 3)")
for kind in fire turned-fire; do
    light $kind.vdb -o lit.vdb --extinction 1e-4 --albedo 0.5 --emission grid:fire
    expect_silent
    expect_json report.json "abs(r['power_injected'] / $power - 1) < 1e-5 and r['balance_error'] < 1e-5"
    info lit.vdb
    expect_json info.json "$grids['emission']['active_voxels'] == 26 ** 3 and $grids['emission']['max'][0] == 1"
    expect_json info.json "$grids['emission']['transform'] == $grids['fire']['transform']"
    expect_json info.json "$grids['emission']['metadata']['raysweep_density'] == 'density'"
    # Scattered light does not grow where smoke is thin: at most albedo q / (4 pi) times the longest way through the fire.
    expect_json info.json "$grids['radiosity']['max'][0] < 0.5 / (4 * math.pi) * 1.2 * 3 ** 0.5"
    for eye in 0.55,0.45,9 9,0.45,0.35 5,4,3; do
        expect_exit 0 "$raysweep" render lit.vdb -o picture.exr --ortho 3.6 --size 96,96 --eye $eye \
            --target 0.55,0.45,0.35 --up 0,1,0 --report picture.json
        # Found: 4e-4, from the picture's pixels.
        expect_json picture.json "abs(r['mean'][0] * 3.6 ** 2 / ($power / (4 * math.pi)) - 1) < 2e-3 and r['emission']"
    done
done

# By its other name; a scale; lit again; the options in the metadata make the same again.
light turned-fire.vdb -o named.vdb --extinction 4 --fire fire --emission-scale 3
light turned-fire.vdb -o typed.vdb --extinction 4 --fire grid:fire --emission-scale 3
light turned-fire.vdb -o option.vdb --extinction 4 --emission grid:fire --emission-scale 3
info named.vdb
json info.json "$grids['radiosity']['metadata']['raysweep_options']" >again.toml
expect_exit 0 "$raysweep" light --config again.toml -o again.vdb
light named.vdb -o relit.vdb --extinction 4 --fire fire --emission-scale 3
for other in typed option again relit; do
    for grid in density fire radiosity emission; do same_grid named.vdb $other.vdb $grid; done
    info $other.vdb
    expect_json info.json "len(r['grids']) == 5 and $grids['emission']['max'][0] == 3"
done
expect_exit 2 "$raysweep" light fire.vdb -o no.vdb --fire fire --emission grid:fire
expect_exit 1 "$raysweep" light fire.vdb -o no.vdb --fire flames
expect_match "there is no grid called 'flames'"

# Another resolution of the smoke, half floats and snapshots leave the fire as it is; without one there is no grid.
light turned-fire.vdb -o half.vdb --extinction 4 --fire fire --emission-scale 3 --resolution 0.5 --half --snapshots 20
expect_json report.json "abs(r['power_injected'] / (3 * $power) - 1) < 1e-5 and r['balance_error'] < 1e-5"
same_grid named.vdb half.vdb emission
same_grid named.vdb half_0020.vdb emission
expect_exit 0 "$raysweep" render half_0020.vdb -o snapshot.exr --size 32,32 --report picture.json
expect_json picture.json "r['emission'] and r['mean'][0] > 0"
light turned-fire.vdb -o plain.vdb --extinction 4 --sky 1
info plain.vdb
expect_json info.json "'emission' not in $grids"

# One of the user's own stays, behind the new one, and is not taken for it.
"$raysweep" generate engine-room -o room.vdb --size 60 --open-front >.out 2>&1
light room.vdb -o room-lit.vdb --emission grid:emission --sweeps 20 --exchange medium
info room-lit.vdb
expect_json info.json "[g['name'] for g in r['grids']].count('emission') == 2 and 'raysweep_density' in r['grids'][0]['metadata']"
light room-lit.vdb -o room-relit.vdb --emission grid:emission --sweeps 20 --exchange medium
expect_exit 0 "$raysweep" compare room-lit.vdb room-relit.vdb --grid 'emission[1]' --max-rms 0
# Lamps on walls are surfaces: they show in radiosity, and there is nothing else.
light room.vdb -o room-solid.vdb --emission grid:emission --sweeps 20 --ramp 0.2,1
info room-solid.vdb
expect_json info.json "[g['name'] for g in r['grids']].count('emission') == 1"

# Fires that cannot be meant.
light no-fire.vdb -o no.vdb --fire fire
expect_match "the fire (grid 'fire') gives off no light: it has no voxel above 0"
light fire.vdb -o no.vdb --fire fire --emission-scale 0
expect_match "--emission-scale is 0"
light fire-beside.vdb -o beside.vdb --extinction 4 --fire fire
expect_match "lies wholly beside the volume"
expect_json report.json "r['power_absorbed'] > 0 and r['balance_error'] < 1e-5"
expect_exit 1 "$raysweep" light nan-fire.vdb -o no2.vdb --fire fire
expect_match "(3, 4, 5)"
light nan-fire.vdb -o no2.vdb --fire fire --repair
expect_match "1 voxel of 'fire' was NaN, infinite or negative and counts as 0"

# Recorded and judged by the machine, which has no memory for fires and says so; what it writes has the fire.
light turned-fire.vdb -o run.vdb --extinction 4 --fire fire --record record.json --tolerance 0 --sweeps 20
expect_exit 0 "$cube4" check run.vdb --replay record.json --max-rms 2e-6 --report check.json
expect_json check.json "r['agrees']"
expect_exit 0 "$cube4" illuminate turned-fire.vdb --replay record.json -o machine.vdb
expect_exit 0 "$raysweep" render machine.vdb -o machine.exr --size 32,32 --report picture.json
expect_json picture.json "r['emission']"
expect_exit 0 "$raysweep" render run.vdb -o run.exr --size 32,32
expect_exit 0 "$raysweep" compare machine.exr run.exr --max-rms 1e-5
expect_exit 0 "$cube4" render run.vdb -o machine.png --size 32,32 --view 0,1,0
expect_match "'emission' gives off by itself is not shown"

# For Blender: with a voxel of 0 more on each side, and moved like all grids by half a voxel of its own.
expect_exit 0 "$raysweep" export run.vdb -o exported.vdb
info exported.vdb
expect_json info.json "$grids['emission']['bounds']['index'] == [[-1] * 3, [24] * 3] and $grids['emission']['max'][0] == 1"
expect_json info.json "$grids['emission']['active_tiles'] == 0 and $grids['emission']['min'][0] == 0"

# Smoke and fire from nothing.
expect_exit 0 "$raysweep" generate explosion -o explosion.vdb --size 40
info explosion.vdb
expect_json info.json "$grids['density']['max'][0] <= 1 and $grids['fire']['type'] == 'vec3s' and $grids['fire']['max'][0] > 10"
light explosion.vdb -o explosion-lit.vdb --extinction 20 --fire fire
expect_silent
expect_json report.json "r['balance_error'] < 1e-5"
expect_exit 0 "$raysweep" generate explosion -o again.vdb --size 40 --threads 1
for grid in density fire; do same_grid explosion.vdb again.vdb $grid; done

expect_no_leftovers .
finish
