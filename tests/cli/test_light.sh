# raysweep light, end to end: what is in the output and the report, and that every option does what it says.
source "$(dirname "$0")/lib.sh" "$@"

"$raysweep" generate cloud -o cloud.vdb --size 40
"$make_volume" materials materials.vdb
light() { expect_exit 0 "$raysweep" light "$@" --report report.json; }
same_grid() { expect_exit 0 "$raysweep" compare "$1" "$2" --grid "$3" --max-rms 0; }
info() { "$raysweep" info "$1" --json >info.json; }
grids="{g['name']: g for g in r['grids']}"
balanced() { expect_json report.json "r['balance_error'] <= 1e-5 and r['power_injected'] > 0"; }

# The report, the grids, their types and metadata.
light cloud.vdb -o lit.vdb --extinction 8 --sun -0.3,0.2,-1,3 --sky 0.3
expect_silent
balanced
for key in voxels_active sweeps seconds seconds_per_sweep power_injected power_absorbed power_escaped power_unshot \
    balance_error converged rms_history plan peak_bytes voxels_thick_share; do
    expect_json report.json "'$key' in r"
done
expect_json report.json "r['converged'] and r['sweeps'] >= 40 and r['rms_history'][-1]['rms'] < 0.01"
expect_json report.json "r['power_unshot'] <= 1e-4 * r['power_injected'] and r['peak_bytes'] > 0"
same_grid cloud.vdb lit.vdb density
info lit.vdb
expect_json info.json "sorted($grids) == ['density', 'radiosity', 'unshot']"
expect_json info.json "all($grids[n]['type'] == 'float' and $grids[n]['active_tiles'] == 0 for n in ('radiosity', 'unshot'))"
expect_json info.json "all($grids[n]['metadata'][k] for n in ('radiosity', 'unshot') for k in
    ('raysweep_version', 'raysweep_options', 'raysweep_density', 'raysweep_extinction'))"
expect_json info.json "all(a - 1 == b for a, b in zip($grids['density']['bounds']['index'][0], $grids['radiosity']['bounds']['index'][0]))"
expect_json info.json "all(a + 1 == b for a, b in zip($grids['density']['bounds']['index'][1], $grids['radiosity']['bounds']['index'][1]))"
expect_json info.json "$grids['radiosity']['min'][0] > 0 and $grids['radiosity']['not_finite'] == 0"

# The options in the metadata are a config file that makes the same again; what is given besides wins.
json info.json "$grids['radiosity']['metadata']['raysweep_options']" >again.toml
expect_exit 0 "$raysweep" light --config again.toml -o again.vdb
same_grid lit.vdb again.vdb radiosity
# Lighting a lit file replaces what the first run added.
light lit.vdb -o relit.vdb --extinction 8 --sun -0.3,0.2,-1,3 --sky 0.3
same_grid lit.vdb relit.vdb radiosity
info relit.vdb
expect_json info.json "len(r['grids']) == 3"

# Threads change nothing, the seed does; all of a grid is the same, not only its mean.
base=(cloud.vdb --extinction 8 --sun -0.3,0.2,-1,3 --tolerance 0 --sweeps 33)
for interpolation in nearest linear; do
    light "${base[@]}" --interpolation $interpolation -o one.vdb --threads 1
    expect_json report.json "r['sweeps'] == 33 and r['converged']"
    balanced
    light "${base[@]}" --interpolation $interpolation -o two.vdb --threads 2
    for grid in radiosity unshot; do same_grid one.vdb two.vdb $grid; done
done
light "${base[@]}" -o one.vdb
light "${base[@]}" -o two.vdb --seed 2
expect_exit 1 "$raysweep" compare one.vdb two.vdb --grid radiosity --max-rms 0
expect_exit 0 "$raysweep" render one.vdb -o one.exr --size 40,40
expect_exit 0 "$raysweep" render two.vdb -o two.exr --size 40,40
expect_exit 0 "$raysweep" compare one.exr two.exr --max-rms 0.05
expect_exit 1 "$raysweep" compare one.exr two.exr --max-rms 0

# Colour: of the light, of the albedo, of a grid; all grids of the input are still there.
light materials.vdb -o lit.vdb --extinction 3 --albedo grid:Cd --emission grid:glow --emission-scale 0.5 --sky 1
balanced
info lit.vdb
expect_json info.json "$grids['radiosity']['type'] == 'vec3s' and $grids['unshot']['type'] == 'vec3s'"
for grid in density reflectance Cd heat glow too-white; do same_grid materials.vdb lit.vdb $grid; done
for coloured in "--sun 0,0,-1,3:1:0.8:0.5" "--point 0.5,0.5,3,9:1:1:0" "--sky 1,0.5,0.2" "--sky 1 --albedo 0.9,0.5,0.1"; do
    light cloud.vdb -o lit.vdb --extinction 8 --tolerance 0.05 $coloured
    balanced
    info lit.vdb
    expect_json info.json "$grids['radiosity']['type'] == 'vec3s'"
done
# Grey: grids of floats, points inside and outside, several suns, what becomes of unshot power, Algorithm 1.
for grey in "--albedo grid:reflectance --emission grid:heat" "--point 0.5,0.5,0.4,1 --point 5,-4,3,9" \
    "--sun 1,0,0,1 --sun -.5,-1,-1,2 --sky 0.2" "--sky 1 --remaining drop" "--sky 1 --remaining spread" \
    "--sky 1 --exchange paper" "--sun 0,0,-1,1 --directions random --zeta 1" "--sun 0,0,-1,1 --quality draft"; do
    light materials.vdb -o lit.vdb --extinction 3 $grey
    balanced
    info lit.vdb
    expect_json info.json "$grids['radiosity']['type'] == 'float'"
done
# What the scene does not need is not made.
light cloud.vdb -o lit.vdb --albedo 0 --sun 0,0,-1,3
balanced
expect_json report.json "r['sweeps'] == 0"
info lit.vdb
expect_json info.json "'unshot' not in $grids"
light cloud.vdb -o lit.vdb --sun 0,0,-1,3 --sweeps 0
balanced
light cloud.vdb -o lit.vdb
expect_match "no light reaches the volume"

# A furnace: all light comes back, so the picture is as bright as the sky behind it.
light cloud.vdb -o lit.vdb --extinction 8 --albedo 1 --sky 1
expect_exit 0 "$raysweep" render lit.vdb -o furnace.exr --background 1 --size 48,48 --report picture.json
expect_json picture.json "all(abs(m - 1) < 5e-3 for m in r['mean'][:3])"

# A phase function: the similar isotropic medium is lit, said, and shown; g = 0 is isotropic scattering.
light cloud.vdb -o lit.vdb --extinction 8 --albedo 0.9 --g 0.5 --sun 0,0,-1,3
balanced
expect_json report.json "'0.55 times the extinction and albedo 0.8182' in r['plan'][0]"
light cloud.vdb -o similar.vdb --extinction 4.4 --albedo 0.8181818 --sun 0,0,-1,3
expect_exit 0 "$raysweep" compare lit.vdb similar.vdb --grid radiosity --max-rms 1e-5
info lit.vdb
expect_json info.json "abs(float($grids['radiosity']['metadata']['raysweep_extinction']) - 4.4) < 1e-6"
expect_exit 0 "$raysweep" render lit.vdb -o a.exr --size 24,24
expect_exit 0 "$raysweep" render similar.vdb -o b.exr --size 24,24
expect_exit 0 "$raysweep" compare a.exr b.exr --max-rms 1e-5
light cloud.vdb -o lit.vdb --extinction 8 --g 0 --sun 0,0,-1,3
light cloud.vdb -o plain.vdb --extinction 8 --sun 0,0,-1,3
same_grid lit.vdb plain.vdb radiosity
# With an albedo grid or a ramp the extinction is a grid of the output, scaled, and the picture is of that.
light materials.vdb -o lit.vdb --extinction 3 --albedo grid:reflectance --g 0.4 --sky 1
info lit.vdb
expect_json info.json "abs($grids['extinction']['max'][0] - 3 * (1 - 0.5 * 0.4)) < 1e-6"
expect_json info.json "float($grids['radiosity']['metadata']['raysweep_extinction']) == 1"
light materials.vdb -o similar.vdb --extinction 2.4 --albedo 0.375 --sky 1
expect_exit 0 "$raysweep" compare lit.vdb similar.vdb --grid radiosity --max-rms 1e-5
light cloud.vdb -o lit.vdb --ramp 0.1,0.5,0.9 --albedo 0.5 --g 0.5 --sky 1
info lit.vdb
expect_json info.json "abs($grids['extinction']['max'][0] * 2 / 40 - 0.75 * 2.302585) < 1e-4"
light cloud.vdb -o lit.vdb --ramp 0.1,0.5,0.9 --albedo 1 --g 0.5 --sky 1 --tolerance 0 --sweeps 600
expect_exit 0 "$raysweep" render lit.vdb -o furnace.exr --background 1 --size 32,32 --report picture.json
expect_json picture.json "all(abs(m - 1) < 5e-3 for m in r['mean'][:3])"

# Half floats.
light cloud.vdb -o half.vdb --extinction 8 --sun 0,0,-1,3 --half
expect_silent
info half.vdb
expect_json info.json "$grids['radiosity']['saved_as_half'] and not $grids['density']['saved_as_half']"
light cloud.vdb -o half.vdb --extinction 8 --sun 0,0,-1,1e7 --half
expect_match "of 'radiosity' are too bright for half floats and were set to 65504"
info half.vdb
expect_json info.json "$grids['radiosity']['max'][0] == 65504"

# --explain says it and stops; --plot, --snapshots, --verbose.
expect_exit 0 "$raysweep" light cloud.vdb --sun 0,0,-1,3 --sky 1,1,0.5 --explain
expect_output "three wavelengths"
expect_output "direct pass: 1 sun"
expect_exit 0 "$raysweep" light cloud.vdb --sky 1 --explain --report explained.json
expect_json explained.json "any('sky' in reason for reason in r['plan']) and r['voxels_active'] > 0"
expect_json explained.json "r['resolution'] == 1 and 'sky=' in r['options']"
rm -f explained.vdb
expect_exit 0 "$raysweep" light cloud.vdb -o explained.vdb --sky 1 --explain
[ ! -e explained.vdb ] || fail "--explain lit the volume"
light cloud.vdb -o lit.vdb --extinction 8 --sky 1 --tolerance 0 --sweeps 60 --snapshots 20 --verbose
expect_match "60 sweeps"
for n in 0020 0040 0060; do
    info lit_$n.vdb
    expect_json info.json "sorted($grids) == ['density', 'radiosity']"
done
if command -v gnuplot >/dev/null; then
    light cloud.vdb -o lit.vdb --extinction 8 --sky 1 --plot plot.svg
    grep -q "<svg" plot.svg || fail "plot.svg is no SVG"
    light cloud.vdb -o lit.vdb --extinction 8 --sky 1 --plot plot.png
    [ "$(head -c 4 plot.png | tail -c 3)" = PNG ] || fail "plot.png is no PNG"
else
    echo "skipped: plots, gnuplot is not here"
fi

# Config files: lists of numbers, repeated lights, flags; the command line wins.
cat >scene.toml <<'TOML'
[light]
extinction = 8
sun = ["-0.3,0.2,-1,3", "1,0,0,1:1:0.5:0"]
albedo = [0.9, 0.8, 0.7]
tolerance = 0
sweeps = 25
half = true
TOML
light cloud.vdb -o config.vdb --config scene.toml
expect_json report.json "r['sweeps'] == 25"
light cloud.vdb -o typed.vdb --extinction 8 --sun -0.3,0.2,-1,3 --sun 1,0,0,1:1:0.5:0 --albedo 0.9,0.8,0.7 \
    --tolerance 0 --sweeps 25 --half
same_grid config.vdb typed.vdb radiosity
light cloud.vdb -o config.vdb --config scene.toml --sweeps 3
expect_json report.json "r['sweeps'] == 3"
printf '[light]\nextinktion = 8\n' >wrong.toml
expect_exit 2 "$raysweep" light cloud.vdb -o config.vdb --config wrong.toml
expect_match "extinktion"

# Every option is documented, and the defaults shown are there.
expect_exit 0 "$raysweep" light --help
for option in --density --extinction --albedo --emission --emission-scale --sun --point --sky --sky-scale --sky-up --sky-rotate \
    --sky-suns --ramp --transfer --g --exchange \
    --tolerance --sweeps --zeta --interpolation --quality --remaining --half --plot --explain --threads --seed --report \
    --quiet --verbose --config; do
    expect_output " $option"
done
expect_output "(default: 0.9)"

# Ctrl-C: exit 130 and a complete file with the answer so far. The first snapshot says that it is under way.
for interpolation in nearest linear; do
    rm -f stop*.vdb
    start_interruptible "$raysweep" light cloud.vdb -o stop.vdb --extinction 8 --sun -0.3,0.2,-1,3 --tolerance 0 --sweeps 1000000 \
        --snapshots 20 --interpolation $interpolation --report report.json
    running=$!
    for _ in $(seq 200); do [ -e stop_0020.vdb ] && break || sleep 0.05; done
    kill -INT $running
    wait $running
    code=$?
    [ $code = 130 ] || fail "exit $code after Ctrl-C"
    expect_match "'stop.vdb' holds the answer so far"
    balanced
    expect_json report.json "not r['converged'] and r['sweeps'] >= 20"
    info stop.vdb
    expect_json info.json "len(r['grids']) == 3 and $grids['radiosity']['min'][0] > 0"
    expect_no_leftovers .
done

if [ -f "$data/vdb/smoke.vdb" ]; then
    light "$data/vdb/smoke.vdb" -o lit.vdb --extinction 0.125 --albedo 0.9 --sun 0.3,-1,0.2,3 --sky 0.3
    balanced
    same_grid "$data/vdb/smoke.vdb" lit.vdb density
else
    echo "skipped: $data/vdb/smoke.vdb is not here"
fi

finish
