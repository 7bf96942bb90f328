# raysweep shoot: photographs from all around and where they were taken from; what it refuses, and what it leaves behind.
# Volumes with colours of their own, too: generate triangles, and how render shows them.
source "$(dirname "$0")/lib.sh" "$@"

# Triangles: three grids, the same for any number of threads, edges soft or not.
expect_exit 0 "$raysweep" generate triangles -o tri.vdb --size 48 --count 40 --report report.json
expect_silent
expect_json report.json "0.03 < r['rms_opacity'] < 0.2 and 0.4 < r['rms_color'] / r['rms_opacity'] < 0.7"
expect_exit 0 "$raysweep" info tri.vdb --json
cp .out tri.json
expect_json tri.json "[g['name'] for g in r['grids']] == ['density', 'opacity', 'Cd']"
expect_json tri.json "abs(r['grids'][0]['transform']['voxel_size'][0] - 2 / 48) < 1e-12 and r['grids'][1]['max'][0] < 1"
expect_exit 0 "$raysweep" generate triangles -o again.vdb --size 48 --count 40 --threads 1
expect_exit 0 "$raysweep" compare again.vdb tri.vdb --max-rms 0
expect_exit 0 "$raysweep" generate triangles -o binary.vdb --size 48 --count 40 --binary
expect_exit 1 "$raysweep" compare binary.vdb tri.vdb --max-rms 0.01
expect_exit 2 "$raysweep" generate sphere -o a.vdb --binary
expect_match "--binary"
expect_exit 2 "$raysweep" generate triangles -o a.vdb --count 0
expect_match "--count 0: must be in [1,100000]"
expect_exit 2 "$raysweep" generate triangles -o a.vdb --size 4
expect_match "--size 4"
expect_exit 2 "$raysweep" generate triangles -o a.vdb --soft 2

# render shows them by their colours, unless there is other light; extinction is the density.
expect_exit 0 "$raysweep" render tri.vdb -o tri.exr --size 64,64 --report report.json
expect_silent
expect_json report.json "r['density'] == 'density' and r['extinction'] == 1 and 0.1 < r['mean'][3] < 0.9 and min(r['mean']) > 0"
expect_exit 0 "$raysweep" light tri.vdb -o lit.vdb --sky 1 --tolerance 0.05
expect_exit 0 "$raysweep" render lit.vdb -o lit.exr --size 64,64
expect_exit 1 "$raysweep" compare lit.exr tri.exr --max-rms 0.01

shoot() {
    expect_exit 0 "$raysweep" shoot "$@" --report report.json
    expect_silent
}
small=(--views 4 --size 40,30)

# A ring with alpha: pictures that render would make, and where they were taken from.
shoot tri.vdb -o ring "${small[@]}" --format exr
[ "$(ls ring | tr '\n' ' ')" = "rig.json transforms.json view_0001.exr view_0002.exr view_0003.exr view_0004.exr " ] || fail "files: $(ls ring)"
expect_json report.json "r['views'] == 4 and r['complete'] and r['seconds'] > 0 and 0 < r['coverage'] < 1 and r['orbit'] == 'ring'"
expect_json ring/transforms.json "[f['file_path'] for f in r['frames']] == ['view_%04d.exr' % n for n in (1, 2, 3, 4)]"
expect_json ring/transforms.json "r['w'] == 40 and r['h'] == 30 and r['fl_x'] == r['fl_y'] and r['camera_model'] == 'PINHOLE'"
# The first camera is in front, at -y, looks along +y with z up; the second is at +x.
expect_json ring/transforms.json "[abs(round(row[3], 9)) > 2 for row in r['frames'][0]['transform_matrix'][:3]] == [False, True, False] and r['frames'][0]['transform_matrix'][1][3] < 0"
expect_json ring/transforms.json "r['frames'][1]['transform_matrix'][0][3] > 2 and abs(r['frames'][0]['transform_matrix'][2][1] - 1) < 1e-12"
expect_json ring/transforms.json "all(-1 <= v <= 1 for corner in r['bounds'] for v in corner)"
eye=$(json ring/transforms.json "','.join(str(row[3]) for row in r['frames'][1]['transform_matrix'][:3])")
target=$(json ring/transforms.json "','.join(str((a + b) / 2) for a, b in zip(*r['bounds']))")
expect_exit 0 "$raysweep" render tri.vdb -o second.exr --size 40,30 --eye="$eye" --target="$target"
expect_exit 0 "$raysweep" compare second.exr ring/view_0002.exr --max-rms 1e-6
shoot tri.vdb -o one "${small[@]}" --format exr --threads 1
for view in 1 2 3 4; do expect_exit 0 "$raysweep" compare one/view_000$view.exr ring/view_000$view.exr --max-rms 0; done

# White and black are the matted picture before them.
shoot tri.vdb -o pair "${small[@]}" --format exr --backdrop white,black
expect_json pair/transforms.json "r['frames'][3]['file_path_white'] == 'view_0004_white.exr' and r['frames'][3]['file_path_black'] == 'view_0004_black.exr'"
shoot tri.vdb -o colour "${small[@]}" --format exr --backdrop 0.2,0.4,0.8
[ -e colour/view_0001.exr ] || fail "files: $(ls colour)"
expect_json colour/rig.json "[round(v, 6) for v in r['backdrops']['color']] == [0.2, 0.4, 0.8]"
shoot tri.vdb -o white "${small[@]}" --backdrop white
[ "$(head -c 4 white/view_0001.png | tail -c 3)" = PNG ] || fail "view_0001.png is no PNG"

# A sphere, parallel rays; the light is the camera's own.
shoot tri.vdb -o sphere --orbit sphere --ortho auto --views 7 --size 32,32 --ambient 0.3 --diffuse 0.7 --light 1,1,0
expect_json sphere/transforms.json "len(r['frames']) == 7 and r['camera_model'] == 'ORTHOGRAPHIC'"
expect_json sphere/rig.json "r['ambient'] == 0.3 and r['diffuse'] == 0.7 and abs(sum(v * v for v in r['light']) - 1) < 1e-9 and r['light'][0] > 0"
expect_exit 0 "$raysweep" shoot tri.vdb -o near "${small[@]}" --ortho 0.5
expect_match "it may be cut off"
expect_json near/transforms.json "abs(r['fl_x'] - 80) < 1e-9"
shoot lit.vdb -o lit "${small[@]}" --up 0,1,0 --arc 180
expect_json lit/rig.json "r['up'] == [0, 1, 0] and r['arc'] == 180"
printf '[shoot]\nviews = 4\nsize = [40, 30]\nformat = "exr"\n' >rig.toml
shoot tri.vdb -o config --config rig.toml
expect_exit 0 "$raysweep" compare config/view_0002.exr ring/view_0002.exr --max-rms 0

# A folder of an earlier rig is replaced as a whole, one with anything else is not touched.
shoot tri.vdb -o ring/ --views 2 --size 20,20
[ "$(ls ring | tr '\n' ' ')" = "rig.json transforms.json view_0001.png view_0002.png " ] || fail "files: $(ls ring)"
mkdir empty mine
shoot tri.vdb -o empty --views 1 --size 20,20
cp ring/view_0001.png mine/holiday.png
before=$(ls -lR mine)
refuse() {
    local code=$1 text=$2
    shift 2
    expect_exit "$code" "$raysweep" shoot "$@"
    expect_match "$text"
    [ "$(ls -lR mine)" = "$before" ] || fail "the folder was touched by $*"
    [ ! -e new ] || fail "a folder was left behind by $*"
    expect_no_leftovers .
}
refuse 1 "'mine': it holds 'holiday.png'" tri.vdb -o mine --views 2
refuse 1 "'tri.json': it is a file" tri.vdb -o tri.json --views 2
refuse 1 "does not exist; create it first" tri.vdb -o no/new --views 2
expect_exit 0 "$raysweep" generate cloud -o cloud.vdb --size 20
refuse 1 "has no grid 'radiosity': run 'raysweep light cloud.vdb" cloud.vdb -o new
refuse 1 "cannot read 'missing.vdb'" missing.vdb -o new
refuse 1 "there is no grid called 'heat'" tri.vdb -o new --density heat
refuse 2 "--output" tri.vdb -o -
refuse 2 "--output" tri.vdb
refuse 2 "--views 0" tri.vdb -o new --views 0
refuse 2 "--arc" tri.vdb -o new --orbit sphere --arc 180
refuse 2 "--arc 0" tri.vdb -o new --arc 0
refuse 2 "--orbit" tri.vdb -o new --orbit line
refuse 2 "--ortho" tri.vdb -o new --ortho 0
refuse 2 "--ortho" tri.vdb -o new --ortho wide
refuse 2 "--ortho" tri.vdb -o new --ortho auto --fov 30
refuse 2 "--fov 180" tri.vdb -o new --fov 180
refuse 2 "at most 1" tri.vdb -o new --ambient 0.5 --diffuse 0.7
refuse 2 "--diffuse 2" tri.vdb -o new --diffuse 2
refuse 2 "--light" tri.vdb -o new --light 1,0,0
refuse 2 "--light" tri.vdb -o new --light 0,0,0 --diffuse 0.5
refuse 2 "'green' is none of alpha" tri.vdb -o new --backdrop green
refuse 2 "'white' is given twice" tri.vdb -o new --backdrop white,white
refuse 2 "--backdrop" tri.vdb -o new --backdrop 1,2
refuse 2 "--size" tri.vdb -o new --size 40
refuse 2 "--format" tri.vdb -o new --format jpg
refuse 2 "--step 0" tri.vdb -o new --step 0
refuse 2 "--step 1e-09" tri.vdb -o new --step 1e-9
refuse 2 "up" tri.vdb -o new --up 0,0,0
expect_exit 1 bash -c "ulimit -f 16; exec '$raysweep' shoot tri.vdb -o new --views 2 --size 200,200 --format exr"
expect_match "cannot write"
[ ! -e new ] || fail "a folder was left behind on a full disk"
expect_no_leftovers .

# Ctrl-C: exit 130; the views that are done and where they were taken from.
start_interruptible "$raysweep" shoot tri.vdb -o stopped --views 9999 --size 100,100 --report report.json
interrupt_after_work $!
code=$?
[ $code = 130 ] || fail "exit $code after Ctrl-C"
expect_match "stopped; 'stopped' holds the first"
views=$(ls stopped/view_*.png | wc -l)
expect_json stopped/transforms.json "len(r['frames']) == $views and $views > 0"
expect_json report.json "r['views'] == $views and not r['complete']"
expect_no_leftovers .

expect_exit 0 "$raysweep" shoot --help
expect_output "--backdrop"

finish
