# raysweep project: X-rays have the sizes, places and values that they should; bad geometries are refused and leave
# nothing behind.
source "$(dirname "$0")/lib.sh" "$@"
need_itk

# box.vdb is 40x40x20 world units, with three holes, in a grid of 64x64x32; sums.py says what is in a file of projections.
"$raysweep" generate box-with-holes --dims 64,64,32 --voxel-size 1 -o box.vdb
"$raysweep" project box.vdb -o p.mha --parallel --views 30 --detector 96,40
cat >sums.py <<'END'
import array, json, sys
data = open(sys.argv[1], "rb").read()
start = data.index(b"ElementDataFile = LOCAL\n") + 24
header = dict(line.split(" = ") for line in data[:start].decode().splitlines())
width, height, views = map(int, header["DimSize"].split())
values = array.array("f", data[start:])
size = width * height
print(json.dumps({
    "dims": [width, height, views], "spacing": header["ElementSpacing"], "offset": header["Offset"],
    "max": max(values), "min": min(values), "different": len(set(values)),
    "sums": [sum(values[v * size:(v + 1) * size]) for v in range(views)]}))
END
project() {
    expect_exit 0 "$raysweep" project "$@" --report report.json
    expect_silent
}
sums() { python3 sums.py "$1" >sums.json; }

# Parallel rays at a pitch of one voxel: every view holds all of the object.
project box.vdb -o p.mha --parallel --views 8 --detector 96,48
sums p.mha
expect_json sums.json "r['dims'] == [96, 48, 8] and r['spacing'] == '1 1 1' and r['offset'] == '-47.5 -23.5 0'"
expect_json sums.json "max(r['sums']) < 1.00045 * min(r['sums']) and r['min'] == 0"  # found: 1.00041
for key in views width height seconds seconds_per_view max mean saturated; do expect_json report.json "'$key' in r"; done
expect_json report.json "r['views'] == 8 and r['width'] == 96 and r['height'] == 48 and 55 <= r['max'] <= 56.6"  # the box's diagonal is 56.57
cp p.mha parallel.mha
json sums.json "sum(r['sums'])" >total.txt
# Twice the extinction, half the pitch. Found: 1.11e-4.
project box.vdb -o p.mha --parallel --views 8 --detector 192,96,0.5 --extinction 2
sums p.mha
expect_json sums.json "abs(sum(r['sums']) / 8 / $(cat total.txt) - 1) < 1.22e-4 and r['offset'] == '-47.75 -23.75 0'"
# The axis passes the volume's middle, or another point on request.
project box.vdb -o p.mha --parallel --views 8 --detector 96,48 --orbit-center 0,0,0
cmp -s p.mha parallel.mha || fail "the axis does not pass the box's middle"
project box.vdb -o p.mha --parallel --views 1 --detector 96,48 --orbit-center 0,30,0
sums p.mha
expect_json sums.json "abs(8 * sum(r['sums']) / $(cat total.txt) - 0.95) < 0.0021"  # 2 of its 40 columns are beside the detector
# Threads change nothing.
project box.vdb -o one.mha --cone 120,180 --views 8 --detector 96,48 --threads 1
project box.vdb -o two.mha --cone 120,180 --views 8 --detector 96,48 --threads 2
cmp -s one.mha two.mha || fail "threads change the projections"

# The geometry that is written gives the same again; so does a config file.
project box.vdb -o p.mha --cone 120,180 --views 8 --detector 96,48 --write-geometry g.json
expect_json g.json "r['beam'] == 'cone' and len(r['views']) == 8 and r['views'][0]['source'] == [120, 0, 0]"
project box.vdb -o again.mha --geometry g.json
cmp -s p.mha again.mha || fail "--write-geometry and --geometry differ"
printf '[project]\ncone = "120,180"\nviews = 8\ndetector = [96, 48]\n' >scan.toml
project box.vdb -o again.mha --config scan.toml
cmp -s p.mha again.mha || fail "a config file says something else"

# Pictures, one a view.
project box.vdb -o picture.exr --parallel --views 8 --detector 96,48
[ "$(ls picture_*.exr | tr '\n' ' ')" = "$(printf 'picture_%04d.exr ' 1 2 3 4 5 6 7 8)" ] || fail "pictures: $(ls)"

# What a detector does: noise follows the seed, saturation and rounding hold.
project box.vdb -o a.mha --parallel --views 8 --detector 96,48 --photons 1000 --extinction 0.05 --seed 3
project box.vdb -o b.mha --parallel --views 8 --detector 96,48 --photons 1000 --extinction 0.05 --seed 3 --threads 1
project box.vdb -o c.mha --parallel --views 8 --detector 96,48 --photons 1000 --extinction 0.05 --seed 4
cmp -s a.mha b.mha || fail "noise depends on threads"
cmp -s a.mha c.mha && fail "noise does not depend on the seed"
project box.vdb -o p.mha --parallel --views 8 --detector 96,48 --saturation 20 --bits 4
sums p.mha
expect_json sums.json "r['max'] == 20 and r['different'] <= 16"
expect_json report.json "r['saturated'] == 5990"

# What was hardly meant is warned of.
expect_exit 0 "$raysweep" project box.vdb -o p.mha --parallel --views 2 --detector 96,48 --photons 1000
expect_match "no photon comes through"
expect_exit 0 "$raysweep" project box.vdb -o p.mha --cone 180,120 --views 2 --detector 96,48
expect_match "are the two swapped?"

# Geometries that make no sense: the file, the view and what is wrong with it.
python3 - <<'END'
import json
good = json.load(open("g.json"))
def write(name, change):
    geometry = json.loads(json.dumps(good))
    change(geometry)
    json.dump(geometry, open(name + ".json", "w"))
write("flat", lambda g: g["views"][3].update(column=[0, 0, 0]))
write("none", lambda g: g["detector"].update(width=0))
write("plane", lambda g: g["views"][2].update(source=g["views"][2]["origin"]))
write("empty", lambda g: g["views"].clear())
write("unknown", lambda g: g.update(scale=1))
def circular(name, **changes):
    turn = dict(sourceToAxis=120, sourceToDetector=180, views=8, arc=360, pixelWidth=1, pixelHeight=1)
    json.dump({"format": "raysweep-geometry", "version": 1, "beam": "cone", "detector": {"width": 96, "height": 48},
               "circular": dict(turn, **changes)}, open(name + ".json", "w"))
circular("turn")
circular("no-distance", sourceToDetector=0)
circular("pitch", pixelWidth=-1)
open("cut.json", "w").write(open("g.json").read()[:700])
END
project box.vdb -o again.mha --geometry turn.json
cmp -s two.mha again.mha || fail "a circular geometry is not that of --cone"
cp p.mha before.mha
refused() {  # CODE TEXT OPTIONS...
    local code=$1 text=$2
    shift 2
    expect_exit "$code" "$raysweep" project "$@"
    expect_match "$text"
    cmp -s p.mha before.mha || fail "an error changed the output: $*"
}
refused 1 "'flat.json': view 3: the detector has no area" box.vdb -o p.mha --geometry flat.json
refused 1 "'none.json': a detector of 0x48 pixels" box.vdb -o p.mha --geometry none.json
refused 1 "'plane.json': view 2: the source lies in the detector's plane" box.vdb -o p.mha --geometry plane.json
refused 1 "'empty.json': the geometry has no views" box.vdb -o p.mha --geometry empty.json
refused 1 "'scale' is not known here" box.vdb -o p.mha --geometry unknown.json
refused 1 "sourceToDetector 0: must be positive" box.vdb -o p.mha --geometry no-distance.json
refused 1 "pixelWidth -1: must be positive" box.vdb -o p.mha --geometry pitch.json
refused 1 "cut.json': it is not valid JSON" box.vdb -o p.mha --geometry cut.json
refused 1 "missing.json': there is no such file" box.vdb -o p.mha --geometry missing.json
scan="--parallel --views 2 --detector 96,48"
refused 1 "the detector misses the volume in every view" box.vdb -o p.mha $scan --orbit-center 500,500,0
refused 1 "missing.vdb" missing.vdb -o p.mha $scan
refused 1 "not an OpenVDB file" g.json -o p.mha $scan
refused 1 "the folder 'no' does not exist" box.vdb -o no/p.mha $scan
refused 1 "the folder 'no' does not exist" box.vdb -o no/p.exr $scan
refused 2 "must end in .mha" box.vdb -o p.tif $scan
refused 2 "--views: is missing" box.vdb -o p.mha --parallel --detector 96,48
refused 2 "--detector: is missing" box.vdb -o p.mha --parallel --views 2
refused 2 "--geometry: is missing" box.vdb -o p.mha --views 2 --detector 96,48
refused 2 "say it one way only" box.vdb -o p.mha $scan --cone 120,180
refused 2 "leave out --views" box.vdb -o p.mha --geometry g.json --views 8
refused 2 "sourceToAxis -5: must be positive" box.vdb -o p.mha --cone=-5,180 --views 2 --detector 96,48
refused 2 "2 numbers separated by commas" box.vdb -o p.mha --cone 180 --views 2 --detector 96,48
refused 2 "'0,48'" box.vdb -o p.mha --parallel --views 2 --detector 0,48
refused 2 "--views" box.vdb -o p.mha --parallel --views 0 --detector 96,48
refused 2 "bits 40" box.vdb -o p.mha $scan --bits 40
refused 2 "photons -4" box.vdb -o p.mha $scan --photons=-4
refused 2 "--output is required" box.vdb $scan
expect_no_leftovers .
expect_exit 0 "$raysweep" project --help
expect_output "--write-geometry"

finish
