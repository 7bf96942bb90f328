# --ramp and --transfer: what light writes with them, that render uses it, and what they refuse.
source "$(dirname "$0")/lib.sh" "$@"

"$raysweep" generate cloud -o cloud.vdb --size 32
light() { expect_exit 0 "$raysweep" light "$@" --report report.json; }
render() { expect_exit 0 "$raysweep" render "$@" --size 32,32 --report picture.json; }
same_grid() { expect_exit 0 "$raysweep" compare "$1" "$2" --grid "$3" --max-rms 0; }
same_picture() { expect_exit 0 "$raysweep" compare "$1" "$2" --max-rms 0; }
info() { "$raysweep" info "$1" --json >info.json; }
grids="{g['name']: g for g in r['grids']}"
sun=(--sun 0.3,-1,-0.5,3 --sky 0.3 --tolerance 0.05)

# The output has the extinction, as voxels and with its origin; its largest value is -ln(1-0.9)/h.
light cloud.vdb -o lit.vdb --ramp 0.1,0.5,0.9 "${sun[@]}"
expect_json report.json "r['balance_error'] <= 1e-5 and 'classified by the ramp 0.1,0.5,0.9' in r['plan'][0]"
info lit.vdb
expect_json info.json "sorted($grids) == ['density', 'extinction', 'radiosity', 'unshot']"
expect_json info.json "abs($grids['extinction']['max'][0] * 2 / 32 - 2.302585) < 1e-5"
expect_json info.json "$grids['extinction']['active_tiles'] == 0 and $grids['extinction']['min'][0] > 0"
expect_json info.json "all($grids[n]['metadata']['raysweep_ramp'] == '0.1,0.5,0.9' and
    float($grids[n]['metadata']['raysweep_extinction']) == 1 and $grids[n]['metadata']['raysweep_density'] == 'density'
    for n in ('extinction', 'radiosity'))"
same_grid cloud.vdb lit.vdb density

# The picture is of that extinction; classified anew it is the same, with another ramp or as fog it is not.
render lit.vdb -o a.exr
render lit.vdb -o b.exr --ramp 0.1,0.5,0.9
same_picture a.exr b.exr
for other in "--ramp 0.3,0.5" "--extinction 8" "--density density"; do
    render lit.vdb -o b.exr $other
    expect_exit 1 "$raysweep" compare a.exr b.exr --max-rms 0.01
    expect_match "is above --max-rms"
done

# A table that says the same gives the same; its text is kept.
cat >ramp.json <<'JSON'
[{"value": 0.1, "opacity": 0}, {"value": 0.5, "opacity": 0.9}]
JSON
light cloud.vdb -o table.vdb --transfer ramp.json "${sun[@]}"
for grid in extinction radiosity unshot; do same_grid lit.vdb table.vdb $grid; done
render table.vdb -o b.exr --transfer ramp.json
same_picture a.exr b.exr
info table.vdb
json info.json "$grids['radiosity']['metadata']['raysweep_transfer']" >again.json
light cloud.vdb -o table.vdb --transfer again.json "${sun[@]}"
same_grid lit.vdb table.vdb radiosity

# The options in the metadata make the same again; lighting the lit file replaces what it had, or drops it.
info lit.vdb
json info.json "$grids['radiosity']['metadata']['raysweep_options']" >again.toml
expect_exit 0 "$raysweep" light --config again.toml -o again.vdb
same_grid lit.vdb again.vdb radiosity
light lit.vdb -o relit.vdb --ramp 0.1,0.5,0.9 "${sun[@]}"
same_grid lit.vdb relit.vdb radiosity
info relit.vdb
expect_json info.json "len(r['grids']) == 4"
light lit.vdb -o fog.vdb --extinction 8 "${sun[@]}"
info fog.vdb
expect_json info.json "sorted($grids) == ['density', 'radiosity', 'unshot']"

# Colours are the albedo, unless one is given.
cat >colours.json <<'JSON'
[{"value": 0.1, "opacity": 0, "color": [0.9, 0.2, 0.1]}, {"value": 0.5, "opacity": 0.9, "color": [0.1, 0.2, 0.9]}]
JSON
light cloud.vdb -o coloured.vdb --transfer colours.json "${sun[@]}"
expect_json report.json "r['balance_error'] <= 1e-5"
info coloured.vdb
expect_json info.json "$grids['radiosity']['type'] == 'vec3s'"
json info.json "$grids['radiosity']['metadata']['raysweep_options']" >again.toml
expect_exit 0 "$raysweep" light --config again.toml -o again.vdb
same_grid coloured.vdb again.vdb radiosity
light cloud.vdb -o grey.vdb --transfer colours.json --albedo 0.9 "${sun[@]}"
same_grid lit.vdb grey.vdb radiosity

# A user's own grid of that name stays, with a warning, and what is shown is ours.
"$make_volume" own-extinction own.vdb
light own.vdb -o lit.vdb --ramp 0,2 "${sun[@]}"
expect_match "has a grid 'extinction' of its own"
info lit.vdb
expect_json info.json "[g['name'] for g in r['grids']].count('extinction') == 2"
render lit.vdb -o a.exr
render lit.vdb -o b.exr --ramp 0,2
same_picture a.exr b.exr
light lit.vdb -o relit.vdb "${sun[@]}"
info relit.vdb
expect_json info.json "[g['name'] for g in r['grids']].count('extinction') == 1"
same_grid own.vdb relit.vdb extinction

# Negative values have a meaning here; --repair takes away only what has none.
"$make_volume" negative negative.vdb
light negative.vdb -o lit.vdb --ramp -3,1 "${sun[@]}"
info lit.vdb
expect_json info.json "$grids['extinction']['active_voxels'] == 960"
"$make_volume" nan nan.vdb
expect_exit 1 "$raysweep" light nan.vdb -o lit.vdb --ramp -3,1 --sky 1
expect_match "the first at index (3, 4, 5)"
light nan.vdb -o lit.vdb --ramp -3,1 "${sun[@]}" --repair
expect_match "1 voxel of 'density' was NaN or infinite and counts as 0"

# A furnace through the whole command.
light cloud.vdb -o lit.vdb --ramp 0.1,0.5,0.9 --albedo 1 --sky 1 --tolerance 0 --sweeps 600
render lit.vdb -o furnace.exr --background 1
expect_json picture.json "all(abs(m - 1) < 5e-3 for m in r['mean'][:3])"

# What they refuse.
usage() {
    local text=$1
    shift
    expect_exit 2 "$raysweep" light missing.vdb -o x.vdb "$@"
    expect_match "$text"
    expect_exit 2 "$raysweep" render missing.vdb -o x.exr "$@"
    expect_match "$text"
    [ ! -e x.vdb ] && [ ! -e x.exr ] || fail "an output appeared"
}
usage "--ramp: a ramp from 1 to 1: both must be finite, and the first below the second" --ramp 1,1
usage "--ramp: a ramp from 1 to 0.2" --ramp 1,0.2
usage "opacity 0: must be in (0,1]" --ramp 0,1,0
usage "opacity 1.01: must be in (0,1]" --ramp 0,1,1.01
usage "'nan' in 'nan,1' is not a number" --ramp nan,1
usage "'inf' in '0,inf' is not a number" --ramp 0,inf
usage "'0' has 1 where 2 to 3 numbers" --ramp 0
usage "--ramp" --ramp 0,1,0.5,2
usage "excludes" --ramp 0,1 --extinction 2
usage "excludes" --transfer ramp.json --extinction 2
usage "excludes" --transfer ramp.json --ramp 0,1
refuse() {
    local text=$1
    shift
    expect_exit 1 "$raysweep" light cloud.vdb -o x.vdb --sky 1 "$@"
    expect_match "$text"
    [ ! -e x.vdb ] || fail "an output appeared"
}
refuse "--transfer: cannot read 'missing.json': there is no such file" --transfer missing.json
refuse "it is a folder" --transfer .
echo '[{"value": 0, "opacity": 0.5}, {"value": 1, "opacity": 1.5}]' >bad.json
refuse "cannot read 'bad.json': point 2: opacity 1.5: must be in [0,1]" --transfer bad.json
echo '[{"value": 0, "opacity"' >bad.json
refuse "'bad.json': it is not valid JSON: parse error at line 2" --transfer bad.json
"$make_volume" frustum frustum.vdb
expect_exit 1 "$raysweep" light frustum.vdb -o x.vdb --sky 1 --ramp 0,1
expect_match "not linear"

finish
