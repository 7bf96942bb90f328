# What a careless or malicious caller tries: outputs onto inputs, values that are none, files that are damaged or never end. A
# message, exit 1 or 2, and nothing lost or left behind.
source "$(dirname "$0")/lib.sh" "$@"
cube4=$(dirname "$raysweep")/raysweep-cube4

"$raysweep" generate sphere -o in.vdb --size 16 --soft 0
"$raysweep" light in.vdb -o lit.vdb --sky 1 --sweeps 20 --tolerance 0 --record run.json
"$raysweep" render lit.vdb -o pic.exr --size 16,16
sum=$(cksum in.vdb lit.vdb run.json run.vdb pic.exr)
# refuse CODE TEXT COMMAND...: fails with TEXT; no input is harmed, nothing is left behind.
refuse() {
    local code=$1 text=$2 before
    shift 2
    before=$(find . -not -name '.out' -not -name '.err' | sort)
    expect_exit "$code" "$@"
    expect_match "$text"
    [ "$(cksum in.vdb lit.vdb run.json run.vdb pic.exr)" = "$sum" ] || fail "an input was harmed by: $*"
    [ "$(find . -not -name '.out' -not -name '.err' | sort)" = "$before" ] || fail "left behind by: $*"
}

# --- Outputs that are inputs, other outputs, or in folders of those, however they are spelt.
mkdir sub shots
ln -s ../in.vdb sub/link.vdb
ln in.vdb sub/hard.vdb
ln -s "$work" sub/here
"$raysweep" shoot lit.vdb -o shots --views 2 --size 8,8
for same in in.vdb ./in.vdb sub/../in.vdb "$work/in.vdb" sub/link.vdb sub/hard.vdb sub/here/in.vdb missing/../in.vdb; do
    refuse 2 "would be written, but is also" "$raysweep" light in.vdb --sky 1 -o "$same"
    refuse 2 "would be written, but is also" "$raysweep" info in.vdb --report "$same"
done
refuse 2 "would be written, but is also" "$raysweep" light in.vdb --sky 1 -o new.vdb --report new.vdb
refuse 2 "would be written, but is also" "$raysweep" light in.vdb --sky 1 -o new.vdb --report ./new.vdb
ln -s nowhere.vdb dangling.vdb
refuse 2 "would be written, but is also" "$raysweep" light in.vdb --sky 1 -o dangling.vdb --report nowhere.vdb
refuse 2 "would be written, but is also" "$raysweep" light in.vdb --sky pic.exr -o new.vdb --report pic.exr
refuse 2 "would be written, but is also" "$raysweep" light in.vdb --sky 1 -o new.vdb --record in.json
refuse 2 "would be written, but is also" "$raysweep" light in.vdb --sky 1 -o new.vdb --plot p.svg --report p.svg
ln -s in.vdb new_0002.vdb
refuse 2 "would be written, but is also" "$raysweep" light in.vdb --sky 1 -o new.vdb --snapshots 2 --sweeps 4
rm new_0002.vdb
echo "sky = 1" >light.toml
cp light.toml kept.toml
refuse 2 "is also --config" "$raysweep" light in.vdb -o new.vdb --config light.toml --report light.toml
cmp -s light.toml kept.toml || fail "the config file was harmed"
refuse 2 "would be written, but is also" "$raysweep" render lit.vdb -o lit.vdb
refuse 2 "would be written" "$raysweep" render lit.vdb -o p.exr -o ./p.exr
refuse 2 "would be written, but is also" "$raysweep" export lit.vdb -o lit.vdb
refuse 2 "would be written, but is also" "$raysweep" compare pic.exr pic.exr --report pic.exr
refuse 2 "would be written, but is also" "$raysweep" generate engine-room --volume in.vdb -o in.vdb
refuse 2 "would be written, but is also" "$raysweep" project in.vdb --parallel --views 2 --detector 8,8 -o p.exr --write-geometry in.vdb
refuse 2 "would be written, but is also" "$raysweep" import in.vdb -o in.vdb
refuse 2 "would be written, but is also" "$raysweep" ct pic.exr --parallel -o in.vdb --reference in.vdb
refuse 2 "holds 'shots/transforms.json'" "$raysweep" photo shots/transforms.json -o new.vdb --save-mattes shots
refuse 2 "would be written, but is also" "$raysweep" photo shots/transforms.json -o new.vdb --save-mattes m --compare-views ./m/
refuse 2 "holds 'shots/r.json'" "$raysweep" shoot lit.vdb -o shots --report shots/r.json
refuse 2 "would be written, but is also" "$cube4" render lit.vdb -o p.exr --view 0,0,-1 --report lit.vdb
refuse 2 "would be written, but is also" "$cube4" check lit.vdb --replay run.json --report run.vdb
refuse 2 "would be written, but is also" "$cube4" illuminate in.vdb -o in.vdb --sky 1

# --- How files are written: with the permissions of what they replace, through links, under long names.
umask 022
echo old >mode.vdb && chmod 640 mode.vdb
expect_exit 0 "$raysweep" generate box -o mode.vdb --size 4
[ "$(stat -c %a mode.vdb)" = 640 ] || fail "permissions became $(stat -c %a mode.vdb)"
rm -f new.vdb
expect_exit 0 "$raysweep" generate box -o new.vdb --size 4
[ "$(stat -c %a new.vdb)" = 644 ] || fail "permissions of a new file are $(stat -c %a new.vdb)"
(umask 077 && "$raysweep" generate box -o private.vdb --size 4)
[ "$(stat -c %a private.vdb)" = 600 ] || fail "umask: permissions are $(stat -c %a private.vdb)"
echo precious >readonly.vdb && chmod 444 readonly.vdb
refuse 1 "it is read-only" "$raysweep" generate box -o readonly.vdb --size 4
[ "$(cat readonly.vdb)" = precious ] || fail "a read-only file was replaced"
ln -s mode.vdb link.vdb
expect_exit 0 "$raysweep" generate box -o link.vdb --size 6
[ -L link.vdb ] && [ "$("$raysweep" info mode.vdb --json | grep -c '"active_voxels": 216')" = 1 ] || fail "the link was not followed"
expect_exit 0 "$raysweep" generate box -o dangling.vdb --size 4
[ -L dangling.vdb ] && [ -f nowhere.vdb ] || fail "a link to nothing was not followed"
long=$(printf 'n%.0s' $(seq 251)).vdb
expect_exit 0 "$raysweep" generate box -o "$long" --size 4
refuse 1 "cannot write" "$raysweep" generate box -o "n$long" --size 4
mkfifo pipe
for target in /dev/null /dev/stdout pipe; do
    refuse 1 "give a file name" "$raysweep" generate box -o $target --size 4
    refuse 1 "give a file name" "$raysweep" info in.vdb --report $target
done
[ -c /dev/null ] && [ -p pipe ] || fail "a device or pipe was replaced"

# --- Of several outputs all appear or none: the last one fails here.
mkdir -p full && if mount -t tmpfs -o size=64k tmpfs full 2>/dev/null; then
    refuse 1 "cannot write 'full/r.json'" bash -c "head -c 65536 /dev/zero >full/fill 2>/dev/null; '$raysweep' light in.vdb --sky 1 -o whole.vdb --report full/r.json; c=\$?; rm full/fill; exit \$c"
    umount full
fi
mkdir -p deep
refuse 1 "cannot read" "$raysweep" photo missing.json -o new2.vdb --save-mattes deep/mattes --compare-views deep/views

# --- Signals.
started() {  # runs in the background with a snapshot every sweep, so that there is always something being written
    start_interruptible "$raysweep" light big.vdb -o signal.vdb --sky 1 --sun 0,0,-1,3 --tolerance 0 --sweeps 100000 --snapshots 1 \
        --quiet
    for _ in $(seq 1200); do compgen -G 'signal_*.vdb' >/dev/null && break || sleep 0.05; done
    compgen -G 'signal_*.vdb' >/dev/null || fail "nothing was written within a minute"
}
"$raysweep" generate cloud -o big.vdb --size 64
for signal in TERM HUP; do
    started
    kill -$signal $!
    wait $! 2>/dev/null
    expect_no_leftovers .
    [ ! -e signal.vdb ] || fail "$signal left an output"
    rm -f signal_*.vdb
done
started
kill -INT $!
kill -INT $! 2>/dev/null
wait $!
expect_no_leftovers .
rm -f signal*.vdb
trap '' INT
"$raysweep" light big.vdb -o ignored.vdb --sky 1 --sun 0,0,-1,3 --tolerance 0 --sweeps 300 --quiet &
sleep 0.5
kill -INT $!
wait $! || fail "SIGINT was not ignored, though it was when the program started"
trap - INT

# --- Values that are none.
value() { refuse 2 "$@"; }
to=(-o none.vdb)
value "--sky: its value is empty" "$raysweep" light in.vdb "${to[@]}" --sky ''
value "--sky" "$raysweep" light in.vdb "${to[@]}" --sky ' '
value "--sun" "$raysweep" light in.vdb "${to[@]}" --sun ,,,
value "--sun" "$raysweep" light in.vdb "${to[@]}" --sun ''
value "--size" "$raysweep" generate box "${to[@]}" --size ''
value "--dims" "$raysweep" generate box "${to[@]}" --dims ''
value "--dims" "$raysweep" generate box "${to[@]}" --dims ,,
value "--extinction" "$raysweep" light in.vdb "${to[@]}" --sky 1 --extinction ''
value "--transfer: its value is empty" "$raysweep" light in.vdb "${to[@]}" --sky 1 --transfer ''
value "--density: its value is empty" "$raysweep" light in.vdb "${to[@]}" --sky 1 --density ''
value "--report: its value is empty" "$raysweep" info in.vdb --report ''
value "file: its value is empty" "$raysweep" info ''
value "--ortho" "$raysweep" render lit.vdb -o p.png --ortho ''
value "--pipelines" "$cube4" render lit.vdb -o p.exr --view 0,0,-1 --pipelines ''
for bad in 0x10 0x1p3 1,5 1e 1.5x '1 2' nan inf -inf 1e400 1e31 +-1 1_000 '٣'; do
    value "--extinction" "$raysweep" light in.vdb "${to[@]}" --sky 1 --extinction="$bad"
    value "--voxel-size" "$raysweep" generate box "${to[@]}" --voxel-size="$bad"
    value "--sun" "$raysweep" light in.vdb "${to[@]}" --sun "0,0,-1,$bad"
done
for bad in 0x10 1.0 1e1 99999999999 -; do value "--size" "$raysweep" generate box "${to[@]}" --size="$bad"; done
expect_exit 0 "$raysweep" generate box -o octal.vdb --size 010
[ "$("$raysweep" info octal.vdb --json | grep -c '"active_voxels": 1000')" = 1 ] || fail "010 is not ten"

# --- Directions of any length; points within reason.
for length in 1 1e160 1e-160; do
    expect_exit 0 "$raysweep" light in.vdb -o far.vdb --sun "0,0,-$length,3" --tolerance 0 --sweeps 2
    [ $length = 1 ] && cp far.vdb near.vdb
    expect_exit 0 "$raysweep" compare far.vdb near.vdb --grid radiosity --max-rms 1e-12
    expect_exit 0 "$raysweep" render lit.vdb -o far.exr --size 16,16 --up "0,0,$length"
    expect_exit 0 "$raysweep" compare far.exr pic.exr --max-rms 1e-6
done
value "the direction has no length" "$raysweep" light in.vdb "${to[@]}" --sun 0,0,0,3
value "'1e-400' in '0,0,1e-400' is not a number" "$raysweep" light in.vdb "${to[@]}" --sun 0,0,1e-400,3
value "within -1e30 and 1e30" "$raysweep" render lit.vdb -o p.png --eye 1e160,0,0
value "within -1e30 and 1e30" "$raysweep" light in.vdb "${to[@]}" --quad 0,0,0,1e160,0,0,0,1e160,0,1
value "no area" "$raysweep" light in.vdb "${to[@]}" --quad 0,0,0,1e-200,0,0,0,1e-200,0,1

# --- Files that are damaged, or never end.
for kind in at-int-max at-int-min; do
    "$make_volume" $kind $kind.vdb
    for command in "info" "light --sky 1 -o none.vdb" "render -o none.png" "export -o none.vdb" "shoot -o none --views 2" \
        "project --parallel --views 2 --detector 8,8 -o none.exr"; do
        set -- $command
        refuse 1 "farther from 0 than" timeout 20 "$raysweep" "$1" $kind.vdb "${@:2}"
    done
    refuse 1 "farther from 0 than" timeout 20 "$raysweep" compare $kind.vdb in.vdb
    refuse 1 "farther from 0 than" timeout 20 "$cube4" illuminate $kind.vdb -o none.vdb --sky 1
done
# Memory follows what is active, not the box around it: 300 MB of addresses would not hold a table of 16 million places.
for kind in far-apart far-apart-diagonal; do
    "$make_volume" $kind $kind.vdb
    expect_exit 0 timeout 300 "$raysweep" light $kind.vdb -o far.vdb --sun 0,0,-1,3 --sky 1 --tolerance 0 --sweeps 8 --threads 2 --report far.json
    expect_json far.json "r['balance_error'] <= 1e-5 and r['peak_bytes'] < 300e6"
done
python3 - <<'END'
import struct
def text(s): return struct.pack('<I', len(s)) + s
head = struct.pack('<qIIIB', 0x56444220, 224, 10, 0, 1) + b'0' * 36
big = struct.pack('<I', 0xffffffff)
files = {
    'name': head + struct.pack('<I', 1) + big,
    'type': head + struct.pack('<I', 1) + text(b'x') + big,
    'value': head + struct.pack('<I', 1) + text(b'x') + text(b'string') + big,
    'unknown': head + struct.pack('<I', 1) + text(b'x') + text(b'??') + big,
    'delayed': head + struct.pack('<I', 1) + text(b'x') + text(b'__delayedload') + struct.pack('<III', 8, 0xf0000000, 0),
    'short': head + struct.pack('<I', 1) + text(b'x') + text(b'float') + struct.pack('<I', 0) ,
    'grid': head + struct.pack('<Ii', 0, 1) + big,
    'gridtype': head + struct.pack('<Ii', 0, 1) + text(b'density') + big,
    'count': head + struct.pack('<I', 0xffffffff),
}
for name, data in files.items():
    open('string-' + name + '.vdb', 'wb').write(data + b'\0' * 16)
END
for file in string-*.vdb; do
    for command in "info" "light --sky 1 -o none.vdb"; do
        set -- $command
        refuse 1 "cannot read '$file'" bash -c "ulimit -v 3000000; timeout 20 '$raysweep' $1 $file ${*:2}"
    done
done
deep=$(printf '[%.0s' $(seq 100000))
echo "$deep" >deep.json
refuse 1 "nested more than" "$raysweep" light in.vdb "${to[@]}" --sky 1 --transfer deep.json
refuse 1 "nested more than" "$raysweep" project in.vdb -o none.exr --geometry deep.json
echo "{\"frames\": $deep" >frames.json
refuse 1 "nested more than" "$raysweep" photo frames.json "${to[@]}"
refuse 1 "cannot read poses" "$raysweep" photo deep.json "${to[@]}"
[ "$(wc -c <.err)" -lt 5000 ] || fail "a message of $(wc -c <.err) bytes"
refuse 1 "nested more than" "$cube4" check lit.vdb --replay deep.json
echo '[{"value": 0, "value": 1, "opacity": 0.5}]' >twice.json
refuse 1 "given twice" "$raysweep" light in.vdb "${to[@]}" --sky 1 --transfer twice.json
printf '[%s]\nx = 1\n' "$(printf 'a.%.0s' $(seq 10000))a" >deep.toml
refuse 2 "nested" bash -c "ulimit -v 3000000; '$raysweep' light in.vdb ${to[*]} --config deep.toml"
printf 'sky = 1\nsky = 2\n' >twice.toml
refuse 2 "line 2: 'sky' is given twice, first in line 1" "$raysweep" light in.vdb "${to[@]}" --config twice.toml
printf 'sun = ["0,0,-1,3",\n' >open.toml
refuse 2 "the list has no end" "$raysweep" light in.vdb "${to[@]}" --config open.toml
printf 'sky = ""\n' >empty.toml
refuse 2 "--sky: its value is empty" "$raysweep" light in.vdb "${to[@]}" --config empty.toml
refuse 2 "--config" timeout 20 "$raysweep" light in.vdb "${to[@]}" --config /dev/zero
refuse 1 "not a regular file" timeout 20 "$raysweep" light /dev/zero "${to[@]}" --sky 1
refuse 1 "does not end" timeout 60 "$raysweep" light in.vdb "${to[@]}" --sky 1 --transfer /dev/zero
ln -s /dev/zero zero.json
refuse 1 "does not end" timeout 60 "$raysweep" project in.vdb -o none.exr --geometry zero.json
refuse 1 "/dev/zero" timeout 60 "$raysweep" photo /dev/zero "${to[@]}"
refuse 1 "does not end" timeout 60 "$cube4" check lit.vdb --replay /dev/zero
refuse 1 "not a regular file" timeout 20 "$raysweep" light in.vdb "${to[@]}" --sky /dev/zero
refuse 1 "not a regular file" timeout 20 "$raysweep" compare /dev/zero pic.exr
for kind in box sphere shepp-logan box-with-holes; do
    refuse 1 "GB" bash -c "ulimit -v 4000000; timeout 100 '$raysweep' generate $kind ${to[*]} --size 4096"
done

# --- A grid that cannot be read does not hide the others.
"$make_volume" materials materials.vdb
sed 's/Tree_vec3s_5_4_3/Tree_vec9s_5_4_3/' materials.vdb >other.vdb
expect_exit 1 "$raysweep" info other.vdb --json
cp .out other.json
expect_json other.json "[g['name'] for g in r['grids']] == ['density', 'reflectance', 'heat', 'too-white']"
expect_json other.json "[g['name'] for g in r['unreadable']] == ['Cd', 'glow']"
expect_match "grid 3 of 6 ('Cd')"
refuse 1 "grid 3 of 6 ('Cd')" "$raysweep" light other.vdb "${to[@]}" --sky 1
# Points whose tree has another background than none end OpenVDB's reader with an assertion.
"$make_volume" points-behind points.vdb
python3 - <<'END'
data = bytearray(open('points.vdb', 'rb').read())
name = b'UniformScaleMap'
at = data.rfind(name) + len(name) + 15 * 8
assert data[at:at + 8] == bytes([1, 0, 0, 0, 0, 0, 0, 0])
data[at + 4] = 210
open('assert.vdb', 'wb').write(data)
END
expect_exit 0 "$raysweep" info points.vdb
refuse 1 "it has points where there can be none" "$raysweep" light assert.vdb "${to[@]}" --sky 1
expect_exit 1 "$raysweep" info assert.vdb
expect_output "density: float"
expect_match "grid 2 of 2 ('density')"

# --- NaN and infinity are no answers.
"$make_volume" voxels-1e30 huge.vdb
refuse 1 "leads beyond what single precision can hold" "$raysweep" light huge.vdb "${to[@]}" --sky 1e30
refuse 2 "within" "$raysweep" light in.vdb "${to[@]}" --sky 3e38
for edge in 1e-5 1e-6; do refuse 1 "give sizes in smaller units" "$raysweep" generate box "${to[@]}" --size 4 --voxel-size $edge; done

# --- Albedo, alpha, volumes in which there is nothing to see.
refuse 1 "--repair clamps it, --albedo-scale scales it" "$raysweep" light materials.vdb "${to[@]}" --sky 1 --albedo grid:too-white
expect_match "the first at index (0, 0, 0)"
expect_exit 0 "$raysweep" light materials.vdb -o clamped.vdb --sky 1 --albedo grid:too-white --repair --sweeps 20
expect_match "960 voxels of 'too-white' were outside [0,1] and count as the nearest value in it"
expect_exit 0 "$raysweep" light materials.vdb -o one.vdb --sky 1 --albedo 1 --sweeps 20
expect_exit 0 "$raysweep" compare clamped.vdb one.vdb --grid radiosity --max-rms 1e-6
expect_exit 0 "$raysweep" light materials.vdb -o scaled.vdb --sky 1 --albedo grid:too-white --albedo-scale 0.5 --sweeps 20
expect_exit 0 "$raysweep" light materials.vdb -o three.vdb --sky 1 --albedo 0.75 --sweeps 20
expect_exit 0 "$raysweep" compare scaled.vdb three.vdb --grid radiosity --max-rms 1e-6
refuse 2 "--albedo-scale: is for --albedo grid:NAME" "$raysweep" light in.vdb "${to[@]}" --sky 1 --albedo-scale 2
"$make_volume" black black.vdb
expect_exit 0 "$raysweep" light black.vdb -o b.vdb --sky 1
expect_match "the density is 0 in all active voxels"
expect_exit 0 "$raysweep" render b.vdb -o b.png --size 8,8
expect_match "nothing of the volume is in the picture"
"$raysweep" render lit.vdb -o other.exr --size 16,16 --extinction 100 --background 0
expect_exit 1 "$raysweep" compare other.exr pic.exr --max-rms 0 --report alpha.json
expect_match "alpha differs"
expect_json alpha.json "r['alpha_rmse'] > 0.01 and r['alpha_max'] <= 1"

finish
