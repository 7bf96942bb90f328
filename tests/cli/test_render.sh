# raysweep render: pictures of the right kind and content, cameras, turntables, and what it refuses.
source "$(dirname "$0")/lib.sh" "$@"

"$raysweep" generate cloud -o cloud.vdb --size 40
"$raysweep" light cloud.vdb -o lit.vdb --extinction 8 --sun 0.3,-1,-0.5,3 --sky 0.3 --tolerance 0.03
"$raysweep" light cloud.vdb -o direct.vdb --extinction 8 --sun 0.3,-1,-0.5,3 --sky 0.3 --sweeps 0
"$raysweep" light cloud.vdb -o white.vdb --extinction 8 --albedo 1 --sky 1 --tolerance 0 --sweeps 2000
render() { expect_exit 0 "$raysweep" render "$@" --report report.json; }
size=(--size 64,48)

# Both formats from one rendering; the report.
render lit.vdb -o a.exr -o a.png "${size[@]}"
expect_silent
expect_json report.json "r['seconds'] >= 0 and len(r['mean']) == 4 and 0 < r['mean'][0] < 1 and 0 < r['mean'][3] < 1"
expect_json report.json "r['extinction'] == 8 and r['density'] == 'density' and r['width'] == 64 and r['height'] == 48"
[ "$(head -c 4 a.png | tail -c 3)" = PNG ] || fail "a.png is no PNG"
# The same for any number of threads; another step is nearly the same; other light is not.
render lit.vdb -o b.exr "${size[@]}" --threads 1
expect_exit 0 "$raysweep" compare b.exr a.exr --max-rms 0
render lit.vdb -o b.exr "${size[@]}" --step 0.25
expect_exit 0 "$raysweep" compare b.exr a.exr --max-rms 0.005
expect_exit 1 "$raysweep" compare b.exr a.exr --max-rms 0
render direct.vdb -o b.exr "${size[@]}"
expect_exit 1 "$raysweep" compare b.exr a.exr --max-rms 0.02
render lit.vdb -o b.exr "${size[@]}" --lambert
expect_exit 1 "$raysweep" compare b.exr a.exr --max-rms 0.02
render lit.vdb -o b.exr "${size[@]}" --samples 2
expect_exit 0 "$raysweep" compare b.exr a.exr --max-rms 0.1
render lit.vdb -o b.png "${size[@]}" --exposure 1
expect_exit 1 "$raysweep" compare b.png a.png --max-rms 0
# Nothing to attenuate, nothing to see.
render lit.vdb -o b.exr "${size[@]}" --extinction 0
expect_json report.json "max(r['mean']) == 0"
render lit.vdb -o b.exr "${size[@]}" --extinction 0 --background 0.2,0.4,0.8
expect_json report.json "all(abs(a - b) < 1e-6 for a, b in zip(r['mean'], (0.2, 0.4, 0.8, 0)))"

# In a white furnace the volume disappears, from anywhere.
for camera in "--up 0,1,0" "--eye 3,2,1 --target 0,0,0 --fov 30" "--eye 0.1,0,0 --target 1,0,0" "--ortho 2.5" \
    "--ortho 1 --eye 0,0,5 --up 0,1,0"; do
    render white.vdb -o b.exr "${size[@]}" --background 1 $camera
    expect_json report.json "all(abs(m - 1) < 5e-3 for m in r['mean'][:3])"
done

# A turntable: numbered frames, the first as without, the last not.
render lit.vdb -o turn.exr "${size[@]}" --turntable 3
expect_json report.json "r['frames'] == 3 and r['complete']"
[ "$(ls turn*)" = "$(printf 'turn_0001.exr\nturn_0002.exr\nturn_0003.exr')" ] || fail "frames: $(ls turn*)"
expect_exit 0 "$raysweep" compare turn_0001.exr a.exr --max-rms 0
expect_exit 1 "$raysweep" compare turn_0003.exr a.exr --max-rms 0.01
printf 'size = [64, 48]\noutput = ["c.exr", "c.png"]\n' >scene.toml
render lit.vdb --config scene.toml
expect_exit 0 "$raysweep" compare c.exr a.exr --max-rms 0

# Ctrl-C: exit 130, whole frames only.
start_interruptible "$raysweep" render lit.vdb -o stop.exr --size 256,256 --turntable 9999
running=$!
for _ in $(seq 200); do [ -e stop_0001.exr ] && break || sleep 0.05; done
kill -INT $running
wait $running
code=$?
[ $code = 130 ] || fail "exit $code after Ctrl-C"
expect_exit 0 "$raysweep" compare stop_0001.exr stop_0001.exr
expect_no_leftovers .
rm -f stop_*

# What it refuses.
echo "the old file" >old.exr
before=$(cksum old.exr)
refuse() {
    local code=$1 text=$2
    shift 2
    expect_exit "$code" "$raysweep" render "$@"
    expect_match "$text"
    [ "$(cksum old.exr)" = "$before" ] || fail "the old file was harmed by $*"
    expect_no_leftovers .
}
refuse 1 "has no grid 'radiosity': run 'raysweep light cloud.vdb" cloud.vdb -o old.exr
refuse 1 "cannot read 'missing.vdb'" missing.vdb -o old.exr
head -c 2000 lit.vdb >cut.vdb
refuse 1 "cut.vdb" cut.vdb -o old.exr
refuse 1 "there is no grid called 'heat'" lit.vdb -o old.exr --density heat
refuse 2 "must end in .exr or .png" lit.vdb -o old.jpg
refuse 2 "--output" lit.vdb -o -
refuse 2 "output" lit.vdb
refuse 2 "--size" lit.vdb -o old.exr --size 64
refuse 2 "--size" lit.vdb -o old.exr --size 0,64
refuse 2 "--size" lit.vdb -o old.exr --size 6.5,64
refuse 2 "--eye" lit.vdb -o old.exr --eye 1,2
refuse 2 "--up" lit.vdb -o old.exr --up up
refuse 2 "up" lit.vdb -o old.exr --up 0,0,0
refuse 2 "fov" lit.vdb -o old.exr --fov 0
refuse 2 "fov" lit.vdb -o old.exr --fov 180
refuse 2 "--ortho" lit.vdb -o old.exr --ortho 2 --fov 30
refuse 2 "orthoWidth" lit.vdb -o old.exr --ortho 0
refuse 2 "step" lit.vdb -o old.exr --step 0
refuse 2 "step" lit.vdb -o old.exr --step 1e-9
refuse 2 "samples" lit.vdb -o old.exr --samples 0
refuse 2 "--background" lit.vdb -o old.exr --background -1
refuse 2 "--exposure" lit.vdb -o old.exr --exposure inf
refuse 2 "--extinction" lit.vdb -o old.exr --extinction -1
refuse 2 "--turntable" lit.vdb -o old.exr --turntable 0
refuse 2 "--frobnicate" lit.vdb -o old.exr --frobnicate
refuse 1 "the folder 'missing' does not exist" lit.vdb -o missing/a.exr
refuse 1 "cannot write 'missing/r.json'" lit.vdb -o old.exr --report missing/r.json
expect_exit 1 bash -c "ulimit -f 16; exec '$raysweep' render lit.vdb -o old.exr --size 256,256"
expect_match "cannot write 'old.exr'"
[ "$(cksum old.exr)" = "$before" ] || fail "the old file was harmed"
expect_no_leftovers .

finish
