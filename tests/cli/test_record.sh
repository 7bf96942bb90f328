# --record of light and ct: two files with what was done; what cannot be recorded is refused and leaves nothing.
source "$(dirname "$0")/lib.sh" "$@"

"$raysweep" generate cloud -o cloud.vdb --size 40
mkdir out
light() { "$raysweep" light cloud.vdb --extinction 8 --sun -0.3,0.2,-1,3 --sky 0.3 --tolerance 0 --sweeps 20 "$@"; }
info() { "$raysweep" info "$1" --json >info.json; }
names="sorted(g['name'] for g in r['grids'])"
# refuse CODE TEXT ARGUMENTS...: fails with TEXT and leaves nothing in out/.
refuse() {
    local code=$1 text=$2
    shift 2
    expect_exit "$code" "$@"
    expect_match "$text"
    [ -z "$(ls -A out)" ] || fail "left behind: $(ls -A out)"
}

# Light: both files, and the answer is what it was.
expect_exit 0 light -o lit.vdb
expect_exit 0 light -o recorded.vdb --record run.json
expect_silent
expect_no_leftovers .
expect_exit 0 "$raysweep" compare lit.vdb recorded.vdb --grid radiosity --max-rms 0
expect_json run.json "r['raysweep_record'] == 'illuminate' and r['fields'] == 'run.vdb' and r['volume']['grid'] == 'density'"
expect_json run.json "len(r['volume']['checksum']) == 16 and r['channels'] == 1 and len(r['albedo']) == 1"
expect_json run.json "r['injections'] == 20 == sum(len(g['beams']) for g in r['groups'] if g['inject'])"
expect_json run.json "r['suns'][0]['direction'] == [-0.3, 0.2, -1] and not r['other_sources'] and r['settled']"
info run.vdb
expect_json info.json "$names == ['deposit', 'extinction', 'settled', 'source', 'unshot', 'unshot_start']"

# The checksum is that of the file's density, whatever was solved in its place.
checksum=$(json run.json "r['volume']['checksum']")
expect_exit 0 light -o recorded.vdb --record coarse.json --resolution 0.5 --repair --half
expect_json coarse.json "r['volume']['checksum'] == '$checksum' and r['lattice'] != json.load(open('run.json'))['lattice']"
expect_exit 0 "$raysweep" light recorded.vdb --sky 1 --sweeps 4 --tolerance 0 -o relit.vdb --record again.json
expect_json again.json "r['volume']['checksum'] == '$checksum'"

# Surfaces have normals.
"$raysweep" generate sphere -o sphere.vdb --size 16
expect_exit 0 "$raysweep" light sphere.vdb --ramp 0,1 --sky 1 --sweeps 4 --tolerance 0 -o lit.vdb --record solid.json
expect_json solid.json "r['surface_opacity'] == 0.1"
info solid.vdb
expect_json info.json "'normal' in $names"

# What cannot be: files that are in each other's way or cannot be written.
to=(-o out/lit.vdb --record out/run.json)
refuse 2 "must end in .json" light -o out/lit.vdb --record out/run.txt
refuse 2 "'out/lit.vdb' would be written" light -o out/lit.vdb --record out/lit.json
refuse 2 "'./cloud.vdb' would be written" light -o out/lit.vdb --record ./cloud.json
refuse 2 "'out/r.json' would be written" light -o out/lit.vdb --report out/r.json --record out/r.json
refuse 1 "missing" light -o out/lit.vdb --record missing/run.json
mkdir folder.vdb
refuse 1 "'folder.vdb'" light -o out/lit.vdb --record folder.json
[ ! -e folder.json ] || fail "half a record"

# CT.
"$raysweep" generate box-with-holes --dims 32,32,16 --voxel-size 1 -o box.vdb
"$raysweep" project box.vdb -o p.exr --parallel --views 9 --detector 48,20
ct() { "$raysweep" ct p_00*.exr --parallel --arc 180 --pitch 1 --size 32,32,16 --spacing 1 "$@"; }
expect_exit 0 ct -o a.vdb --iterations 2 --nonnegative
expect_exit 0 ct -o vol.vdb --iterations 2 --nonnegative --record ct.json
expect_silent
expect_exit 0 "$raysweep" compare a.vdb vol.vdb --max-rms 0
expect_exit 0 "$raysweep" compare vol.vdb ct.vdb --grid density --max-rms 0
expect_json ct.json "r['raysweep_record'] == 'reconstruct' and len(r['updates']) == 18 and len(r['geometry']['views']) == 9"
expect_json ct.json "r['grid']['dims'] == [32, 32, 16] and r['lower'] == 0 and r['upper'] is None and r['support'] == 'automatic'"
info ct.vdb
expect_json info.json "$names == ['density', 'projections', 'support']"
expect_exit 0 ct -o vol.vdb --method sirt --initial a.vdb --support none --record sirt.json
expect_json sirt.json "all(len(u['views']) == 9 for u in r['updates'])"
info sirt.vdb
expect_json info.json "$names == ['density', 'initial', 'projections']"
for method in fbp fdk; do
    refuse 2 "--record: is for iterative methods, not for $method" ct -o out/vol.vdb --method $method --record out/run.json
done
refuse 2 "'out/vol.vdb' would be written" ct -o out/vol.vdb --record out/vol.json
refuse 1 "missing" ct -o out/vol.vdb --record missing/run.json

finish
