# raysweep ct, end to end: volumes come back from their X-rays, in their place, by every method and from every kind of
# file; what is in the report; what cannot be reconstructed is refused with a message and leaves outputs as they were.
source "$(dirname "$0")/lib.sh" "$@"
need_itk

# Projections made here with Python's standard library; mha(name, ...) writes a file, values(name) reads what
# `project` wrote.
cat >mha.py <<'END'
import array
def values(name):
    data = open(name, "rb").read()
    return array.array("f", data[data.index(b"ElementDataFile = LOCAL\n") + 24:])
def mha(name, dims, samples, code="f", spacing=1, more=""):
    kind = {"f": "FLOAT", "H": "USHORT"}[code]
    offset = [-spacing * (n - 1) / 2 for n in dims[:2]]
    header = ("ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n%sOffset = %g %g 0\n"
              "ElementSpacing = %g %g 1\nDimSize = %d %d %d\nElementType = MET_%s\nElementDataFile = LOCAL\n"
              % (more, *offset, spacing, spacing, *dims, kind))
    open(name, "wb").write(header.encode() + array.array(code, samples).tobytes())
END

# box.vdb is 40x40x20 world units, with three holes, in a grid of 64x64x32.
"$raysweep" generate box-with-holes --dims 64,64,32 --voxel-size 1 -o box.vdb
"$raysweep" project box.vdb -o p.mha --parallel --views 30 --detector 96,40
"$raysweep" project box.vdb -o c.mha --cone 120,180 --views 30 --detector 128,64 --write-geometry c.json
"$raysweep" project box.vdb -o p.exr --parallel --views 30 --detector 96,40
grid="--size 64,64,32 --spacing 1"
ct() { expect_exit 0 "$raysweep" ct "$@" --report report.json; }
rms_below() { expect_exit 0 "$raysweep" compare "$1" box.vdb --max-rms "$2"; }
same() { expect_exit 0 "$raysweep" compare "$1" "$2" --max-rms 0; }

# Every method, for both beams; what the report says. Limits are at most 10 % above what is found, unless said otherwise.
by_sart_and_filtering() {  # BEAM RMS RESIDUAL RMS-OF-FBP
    local beam=$1 rms=$2 residual=$3 direct=$4
    ct $beam -o vol.vdb $grid --nonnegative --relaxation 0.9 --iterations 3 --reference box.vdb
    expect_silent
    for key in seconds seconds_per_update updates residual_history rms_history peak_bytes; do
        expect_json report.json "'$key' in r"
    done
    expect_json report.json "r['dims'] == [64, 64, 32] and r['updates'] == 90 and r['termination'] == 'iterations'"
    expect_json report.json "len(r['rms_history']) == 3 and r['rms_history'] == sorted(r['rms_history'])[::-1]"
    expect_json report.json "r['rms_history'][-1] < $rms and r['residual_history'][-1] < $residual"
    expect_json report.json "r['input']['views'] == 30 and r['input']['format'] == 'MetaImage'"
    ct $beam -o direct.vdb $grid --method fbp --reference box.vdb
    expect_json report.json "r['rms'] < $direct"
}
by_sart_and_filtering "p.mha --parallel --arc 180" 0.0143 0.0039 0.101     # found: 0.0130 0.0036 0.092
by_sart_and_filtering "c.mha --cone 120,180 --arc 360" 0.0562 0.0128 0.143  # found: 0.0511 0.0117 0.131
ct c.mha --cone 120,180 -o fdk.vdb $grid --method fdk
same fdk.vdb direct.vdb
ct p.mha --parallel -o vol.vdb $grid --method os-sart --subset 5 --reference box.vdb
expect_json report.json "r['updates'] == 30 and r['rms_history'][-1] < 0.087"  # found: 0.0793
ct p.mha --parallel -o vol.vdb $grid --method sirt --relaxation 1 --iterations 10 --reference box.vdb
expect_json report.json "r['updates'] == 10 and r['rms_history'][0] < 0.244 and r['rms_history'][-1] < 0.112"  # found: 0.222, 0.1025
ct p.mha --parallel -o vol.vdb $grid --support none --tv 0.2 --reference box.vdb
expect_json report.json "r['voxels_kept'] >= 64 * 64 * 32 and r['rms_history'][-1] < 0.035"  # found: 0.0319
ct p.mha --parallel -o vol.vdb $grid --stop-residual 0.05 --iterations 50
expect_json report.json "r['termination'] == 'residual' and r['updates'] == 60 and r['residual_history'][-1] < 0.05"
for order in random sequential golden; do ct p.mha --parallel -o $order.vdb $grid --order $order --iterations 1; done

# The output's ending says what it becomes; all hold the same voxels in the same place.
for out in vol.mha vol.nrrd vol.nii vol.nii.gz vol vol.d/; do
    ct p.mha --parallel -o $out $grid --iterations 1 --order golden
    expect_exit 0 "$raysweep" import $out -o back.vdb --report back.json
    expect_json back.json "r['dims'] == [64, 64, 32]"
    same back.vdb golden.vdb
done
ct p.mha --parallel -o vol $grid --iterations 1  # what it wrote itself is replaced
echo mine >vol/notes.txt
expect_exit 1 "$raysweep" ct p.mha --parallel -o vol $grid
expect_match "it holds 'notes.txt'"

# Nothing is lost where the grid is all that the detector sees, as it is without --size: support stays that of the object.
ct p.mha --parallel -o all.vdb
expect_json report.json "r['dims'] == [96, 96, 40] and r['voxels_kept'] == 73728"  # a fifth
rms_below all.vdb 0.039  # found: 0.0356

# Voxels that are no cubes, by every method; a volume of such voxels is projected, compared with and started from as it is.
for method in sart os-sart sirt fbp; do
    ct p.mha --parallel -o long.vdb --size 64,64,16 --spacing 1,1,2 --method $method
    expect_json report.json "r['dims'] == [64, 64, 16] and r['spacing'] == [1, 1, 2]"
done
ct c.mha --cone 120,180 -o wide.vdb --spacing 2,1,1 --method fdk
expect_json report.json "r['spacing'] == [2, 1, 1] and abs(2 * r['dims'][0] - r['dims'][1]) <= 1"
ct p.mha --parallel -o long.vdb --size 64,64,16 --spacing 1,1,2 --nonnegative --tv 0.2 --slices slices.png
expect_exit 0 "$raysweep" info long.vdb
expect_output "(1, 1, 2)"
"$raysweep" project long.vdb -o q.mha --parallel --views 30 --detector 96,40
ct q.mha --parallel -o vol.vdb --reference long.vdb --nonnegative --iterations 1
expect_json report.json "r['spacing'] == [1, 1, 2] and r['rms_history'][0] < 0.1"
ct q.mha --parallel -o vol.vdb --initial long.vdb --iterations 1
expect_json report.json "r['residual_history'][0] < 1e-6"  # the last bits

# Starting from another volume.
ct p.mha --parallel -o a.vdb $grid --method fbp
ct p.mha --parallel -o vol.vdb $grid --initial a.vdb --iterations 1
ct p.mha --parallel -o b.vdb $grid --initial fbp --iterations 1
same vol.vdb b.vdb
ct p.mha --parallel -o vol.vdb $grid --initial box.vdb --iterations 1
expect_json report.json "r['residual_history'][0] < 1e-7"  # the last bits

# Threads change nothing, the order's seed does; --half is as good; --config says the same as options.
ct p.mha --parallel -o one.vdb $grid --order random --iterations 1 --threads 1
ct p.mha --parallel -o two.vdb $grid --order random --iterations 1 --threads 2
same one.vdb two.vdb
ct p.mha --parallel -o two.vdb $grid --order random --iterations 1 --seed 2
expect_exit 1 "$raysweep" compare one.vdb two.vdb --max-rms 0
ct p.mha --parallel -o two.vdb $grid --order random --iterations 1 --half
expect_exit 0 "$raysweep" compare one.vdb two.vdb --max-rms 1.77e-4  # found: 1.61e-4; halves have 11 bits
printf 'parallel = true\nsize = [64, 64, 32]\nspacing = 1\norder = "random"\niterations = 1\n' >ct.toml
ct p.mha -o two.vdb --config ct.toml
same one.vdb two.vdb

# Pictures, a folder of them, pages of a TIFF and one MetaImage hold the same; so do geometry files and options.
python3 - <<'END'
from mha import *
import struct
pixels, width, height = values("p.mha"), 96, 40
size = 4 * width * height
tiff = b"II*\0" + struct.pack("<I", 8)
for view in range(30):  # float, not compressed, one strip
    tags = [(256, 3, width), (257, 3, height), (258, 3, 32), (259, 3, 1), (262, 3, 1), (273, 4, len(tiff) + 126),
            (277, 3, 1), (278, 3, height), (279, 4, size), (339, 3, 3)]
    following = len(tiff) + 126 + size if view < 29 else 0
    tiff += struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", t, kind, 1, v) for t, kind, v in tags)
    tiff += struct.pack("<I", following)
    tiff += pixels[view * width * height:(view + 1) * width * height].tobytes()
open("pages.tif", "wb").write(tiff)
END
ct pages.tif --parallel -o two.vdb --config ct.toml
same one.vdb two.vdb
mkdir pictures && cp p_*.exr pictures
ct p_*.exr --parallel -o two.vdb --config ct.toml
same one.vdb two.vdb
ct pictures --parallel -o two.vdb --config ct.toml
same one.vdb two.vdb
ct c.mha --cone 120,180 -o a.vdb $grid --iterations 1
ct c.mha --geometry c.json -o b.vdb $grid --iterations 1
same a.vdb b.vdb

# Where the geometry has its axis the object is looked for.
python3 - <<'PY'
import json
geometry = json.load(open("c.json"))
for view in geometry["views"]:
    for point in ("source", "origin"):
        view[point] = [a + b for a, b in zip(view[point], (500, -300, 200))]
json.dump(geometry, open("far.json", "w"))
PY
ct c.mha --geometry c.json -o b.vdb $grid --iterations 1
kept=$(python3 -c "import json; print(json.load(open('report.json'))['voxels_kept'])")
ct c.mha --geometry far.json -o far.vdb $grid --iterations 1
expect_json report.json "max(abs(a - b) for a, b in zip(r['center'], (500, -300, 200))) < 1e-5 and r['voxels_kept'] == $kept"

# RTK's world has y as axis: what was projected by the same rays, said in JSON, comes back in its place.
python3 - <<'END'
import json, math
width, height, views, sid, sdd, pitch = 96, 64, 30, 120, 180, 1.25
rays, xml = [], []
for n in range(views):
    angle = 2 * math.pi * n / views
    s, c = math.sin(angle), math.cos(angle)
    column, row, middle = [c * pitch, 0, -s * pitch], [0, pitch, 0], [(sid - sdd) * s, 0, (sid - sdd) * c]
    first = [middle[i] - column[i] * (width - 1) / 2 - row[i] * (height - 1) / 2 for i in range(3)]
    rays.append({"source": [sid * s, 0, sid * c], "origin": first, "column": column, "row": row})
    xml.append("<Projection><GantryAngle>%.12g</GantryAngle></Projection>" % (360 * n / views))
json.dump({"format": "raysweep-geometry", "version": 1, "beam": "cone",
           "detector": {"width": width, "height": height}, "views": rays}, open("rtk.json", "w"))
open("rtk.xml", "w").write("""<?xml version="1.0"?><!DOCTYPE RTKGEOMETRY><RTKThreeDCircularGeometry version="3">
<SourceToIsocenterDistance>%g</SourceToIsocenterDistance><SourceToDetectorDistance>%g</SourceToDetectorDistance>
%s</RTKThreeDCircularGeometry>""" % (sid, sdd, "\n".join(xml)))
END
expect_exit 0 "$raysweep" project box.vdb -o rtk.mha --geometry rtk.json
ct rtk.mha --geometry rtk.xml -o a.vdb $grid --nonnegative
rms_below a.vdb 0.073  # found: 0.0664
ct rtk.mha --geometry rtk.json -o b.vdb $grid --nonnegative
expect_exit 0 "$raysweep" compare a.vdb b.vdb --max-rms 1e-6  # the last bits of angles
expect_exit 1 "$raysweep" ct p_*.exr --geometry rtk.xml -o a.vdb
expect_match "'rtk.xml': RTK's geometries say nothing about the detector's pixels"

# Counts with flat and dark frames, one dead pixel, and pixels that no photon reached.
python3 - <<'END'
from mha import *
import math
p = values("p.mha")
size = 96 * 40
flat, dark = [50000 + i % 7 * 300 for i in range(size)], [100 + i % 3 for i in range(size)]
flat[20 * 96 + 30] = 110
mha("flat.mha", [96, 40, 2], flat * 2, "H")
mha("dark.mha", [96, 40, 3], dark * 3, "H")
mha("few.mha", [96, 40, 1], flat[:960] + dark[960:], "H")
mha("counts.mha", [96, 40, 30], [round(dark[i % size] + (flat[i % size] - dark[i % size]) * math.exp(-0.05 * p[i]))
                                 for i in range(len(p))], "H")
END
ct counts.mha --flat flat.mha --dark dark.mha --scale 20 --parallel --arc 180 -o vol.vdb $grid
expect_silent
expect_json report.json "r['input']['pixels_dead'] == 1 and r['input']['values_not_measured'] == 30"
expect_json report.json "r['input']['values_saturated'] == 0"
rms_below vol.vdb 0.0475  # found: 0.0432
ct counts.mha --flat flat.mha --dark dark.mha --scale 20 --parallel -o vol.vdb $grid --method fbp
ct counts.mha --flat few.mha --dark dark.mha --parallel -o vol.vdb $grid
expect_match "2880 of 3840 pixels are dead; are --flat and --dark what they should be?"
ct p.mha --saturation 30 --parallel -o vol.vdb $grid
expect_json report.json "r['input']['values_saturated'] == 18027"

# What a file leaves open is asked for, or assumed aloud.
ct p.mha --parallel -o a.vdb $grid --iterations 1
expect_match "assumed: the 30 views are evenly spread over 180 degrees; --arc or --angles say otherwise"
expect_json report.json "len(r['input']['assumed']) == 1 and r['rows_cut'] == 0 and 'field_radius' not in r"
python3 - <<'END'
from mha import *
import math, struct
p = values("p.mha")
open("angles.txt", "w").write("# degrees\n" + "\n".join(str(6.0 * n) for n in range(30)))
open("radians.txt", "w").write(", ".join(repr(math.radians(6.0 * n)) for n in range(30)))
open("few.txt", "w").write("0 6 12")
mha("transmissions.mha", [96, 40, 30], [math.exp(-0.05 * v) for v in p])
mha("rows.mha", [96, 30, 40], [p[(view * 40 + row) * 96 + x] for row in range(40) for view in range(30) for x in range(96)])
middle = [p[(view * 40 + 20) * 96 + x] for view in range(30) for x in range(96)]
mha("sinogram.mha", [96, 30, 1], middle)
mha("row.mha", [96, 1, 30], middle)
p[5 * 96 * 40 + 3 * 96 + 48] = 1e30
mha("hot.mha", [96, 40, 30], p)
mha("all.mha", [96, 40, 30], [3e38] * len(p))
END
for angles in angles.txt radians.txt; do
    ct p.mha --parallel -o b.vdb $grid --iterations 1 --angles $angles
    expect_exit 0 "$raysweep" compare a.vdb b.vdb --max-rms 1e-6  # the last bits of angles
done
ct p.mha --parallel -o b.vdb $grid --iterations 1 --angles <(cat angles.txt)  # which can be read once only
expect_exit 0 "$raysweep" compare a.vdb b.vdb --max-rms 1e-6
ct p.mha --parallel -o b.vdb $grid --iterations 1 --angles radians.txt
expect_match "assumed: the angles are taken for radians, as they cover 3.142; if they are degrees, say so with --angle-unit"
expect_exit 0 "$raysweep" project box.vdb -o again.mha --parallel --angles angles.txt --detector 96,40
python3 -c "from mha import *; assert max(abs(a - b) for a, b in zip(values('p.mha'), values('again.mha'))) < 1e-4" ||
    fail "project --angles differs"

# Sinograms: a single picture by itself, several where they are asked for or nothing else fits.
ct row.mha --parallel -o a.vdb --iterations 2
ct sinogram.mha --parallel -o b.vdb --iterations 2
expect_match "assumed: the picture is taken for a sinogram, of 96 detector columns in 30 views"
same a.vdb b.vdb
ct p.mha --parallel -o a.vdb $grid --iterations 1
for how in --sinograms "--views 30" "--angles angles.txt"; do
    ct rows.mha --parallel -o b.vdb $grid --iterations 1 $how
    expect_exit 0 "$raysweep" compare a.vdb b.vdb --max-rms 1e-6
done

# Transmissions and counts without frames.
ct transmissions.mha --parallel -o b.vdb $grid
expect_match "as transmissions are, but are taken for line integrals; if they are none, say with --flat"
ct transmissions.mha --flat 1 --scale 20 --parallel -o b.vdb $grid
expect_match "assumed: without beam 0 is counted"
rms_below b.vdb 0.0475  # as from counts
ct transmissions.mha --flat auto --scale 20 --parallel -o c.vdb $grid
expect_match "assumed: without object 1 is counted"
expect_exit 0 "$raysweep" compare b.vdb c.vdb --max-rms 1e-6

# A broken pixel is left out, and neither empties a volume nor leaves it as infinity.
for method in sart fbp; do
    ct hot.mha --parallel -o b.vdb $grid --method $method
    expect_match "1 value can be no measurement"
    expect_json report.json "r['input']['values_implausible'] == 1 and r['input']['values_not_measured'] == 1"
done
rms_below b.vdb 0.128  # found: 0.1165, as without it

# Objects wider than the detector: 24 of the box's 40 columns, and all of its 20 rows of 40. Inside the field it is there, outside is nothing.
"$raysweep" project box.vdb -o cut.mha --parallel --views 60 --detector 24,40
for method in sart fbp; do
    ct cut.mha --parallel -o b.vdb --method $method
    expect_match "the object is wider than the detector: 50 % of its rows end within it"
    expect_json report.json "r['rows_cut'] == 0.5 and abs(r['field_radius'] - 12) < 1e-9"
done

# Pictures and curves.
ct p.mha --parallel -o vol.vdb $grid --slices slices.png --plot plot.svg --history 10 --iterations 2 --reference box.vdb
expect_json report.json "r['updates_history'] == [10, 20, 30, 40, 50, 60] and len(r['rms_history']) == 6"
for picture in slices.png plot.svg; do [ -s $picture ] || fail "there is no $picture"; done

# Ctrl-C: the volume so far, and 130.
start_interruptible "$raysweep" ct p.mha --parallel -o stopped.vdb $grid --iterations 1000000 --report report.json
interrupt_after_work $!
[ $? = 130 ] || fail "Ctrl-C did not end with 130"
expect_match "'stopped.vdb' holds the volume so far"
expect_json report.json "r['termination'] == 'interrupted' and r['updates'] > 0"
rms_below stopped.vdb 0.1  # after a second, however far that is

# What was hardly meant is warned of.
ct c.mha --cone 12,18 -o vol.vdb
expect_match "lengths were given in the wrong unit (mm, cm)"
ct c.mha --cone 120,180 -o vol.vdb --size 16,16,8 --spacing 10
expect_match "voxels are 15 times as large as the detector's pixels"
sed 's/ElementSpacing = 1.25 1.25/ElementSpacing = 12.5 12.5/' rtk.mha >mm.mha
ct mm.mha --geometry rtk.json -o vol.vdb $grid --iterations 1
expect_match "are both in the same unit (mm, cm)?"
ct p.mha --parallel -o vol.vdb --size 24,64,32 --spacing 1
expect_match "the object is larger than the volume: "
ct p.mha --parallel -o vol.vdb --size 64,64,8 --spacing 1  # slices are apart
! grep -q "larger than the volume" "$work/.err" || fail "slices of parallel rays need no others"
ct p.mha --parallel --arc 120 -o vol.vdb $grid --method fbp
expect_match "but filtered backprojection needs 180.0: expect streaks"
ct c.mha --cone 120,180 --arc 200 -o vol.vdb $grid --method fdk
expect_match "(half a turn and the angle of the fan): expect streaks"
ct p.mha --parallel -o vol.vdb --size 16,16,16 --spacing 1 --volume-center 200,0,0
expect_match "of 30 views only"
python3 -c "from mha import *; mha('zero.mha', [96, 40, 30], [0] * 96 * 40 * 30)"
ct zero.mha --parallel -o vol.vdb $grid
expect_match "the volume is empty"

# What cannot be reconstructed: one line that says what and where; vol.vdb stays.
python3 - <<'END'
from mha import *
nan, p = float("nan"), values("p.mha")
data = open("p.mha", "rb").read()
open("cut.mha", "wb").write(data[:-1000])
open("empty.mha", "wb").close()
open("long.mha", "wb").write(b"NDims = 3\n" + 300 * b"y" + b" = 3\nDimSize = 3 3 3\nElementDataFile = LOCAL\n")
mha("unmeasured.mha", [96, 40, 30], [nan] * len(p))
p[3 * 96 * 40 + 5 * 96 + 7] = nan
mha("nan.mha", [96, 40, 30], p)
open("words.txt", "w").write("hello\n")
turn = """{"format": "raysweep-geometry", "version": 1, "beam": "parallel", "detector": {"width": 96, "height": 40},
 "circular": {%s"views": 2147483647, "arc": 180, "pixelWidth": 1, "pixelHeight": 1}}"""
open("endless.json", "w").write(turn % "")
open("twice.json", "w").write(turn % '"views": 30, ')
open("empty.h5", "wb").close()
open("few.json", "w").write(open("c.json").read().replace('"views": [\n', '"views": [\n', 1).rsplit(",\n{", 1)[0] + "\n]\n}\n")
END
cp box.vdb vdb.mha
"$raysweep" generate box-with-holes --dims 64,64,32 --voxel-size 1.5 -o apart.vdb
cp box.vdb vol.vdb
refused() {  # CODE TEXT OPTIONS...
    local code=$1 text=$2
    shift 2
    expect_exit "$code" "$raysweep" ct "$@"
    expect_match "$text"
    [ "$code" = 2 ] || [ "$(grep -vc '^raysweep: assumed: ' "$work/.err")" = 1 ] || fail "not one line: $*"
    cmp -s vol.vdb box.vdb || fail "an error changed the output: $*"
}
out="-o vol.vdb"
refused 1 "the geometry has 29 views, but the projections have 30" c.mha $out --geometry few.json
refused 1 "few.txt' has 3 angles, but the projections have 30 views" p.mha $out --parallel --angles few.txt
refused 1 "words.txt': line 1: 'hello' is no angle" p.mha $out --parallel --angles words.txt
refused 1 "--spacing 1e+25: must be more than a billionth" p.mha $out --parallel --spacing 1e25
refused 1 "--spacing 1e+25: must be more than a billionth" p.mha $out --parallel --spacing 1e25 --method fbp
refused 1 "--spacing 1e+25: must be more than a billionth" p.mha $out --parallel --spacing 1,1,1e25
refused 1 "--spacing 1e-12: must be more than a billionth" p.mha $out --parallel --spacing 1,1e-12,1 --size 9,9,9
refused 1 "no ray was measured" all.mha $out --parallel
refused 1 "it does not end" p.mha $out --parallel --angles /dev/zero
ln -s /dev/zero endless.h5
refused 1 "it is a device or a pipe" endless.h5 $out
refused 1 "orbit views 2147483647: must be 1 to 1048576" p.mha $out --geometry endless.json
refused 1 "'views' is given twice" p.mha $out --geometry twice.json
refused 1 "the geometry has 20 views, but the projections have 30" p.mha $out --parallel --views 20
refused 1 "the geometry has 90 detector columns, but the projections have 96" p.mha $out --parallel --detector 90,40
refused 1 "the detector misses the volume in every view" p.mha $out --parallel $grid --volume-center 0,0,900
refused 1 "the detector misses the volume in every view" p.mha $out --parallel $grid --volume-center 0,0,900 --method fbp
refused 1 "'nan.mha' has 1 value that is NaN or infinite, the first in view 3, row 5, column 7" nan.mha $out --parallel
expect_match "--repair"
refused 1 "'unmeasured.mha': no ray was measured" unmeasured.mha $out --parallel --repair
refused 1 "cannot read 'cut.mha': its data end too early" cut.mha $out --parallel
refused 1 "cannot read 'empty.mha'" empty.mha $out --parallel
refused 1 "cannot read 'long.mha': in its header" long.mha $out --parallel
refused 1 "cannot read 'vdb.mha': in its header, line 1: this is no text" vdb.mha $out --parallel
refused 1 "missing.mha': there is no such file" missing.mha $out --parallel
refused 1 "it is of no kind that is known; give MetaImage" words.txt $out --parallel
refused 1 "it is a sparse volume" box.vdb $out --parallel
refused 1 "it is a geometry" c.json $out --parallel
refused 1 "cannot read 'empty.h5'" empty.h5 $out
refused 1 "missing.h5': there is no such file" missing.h5 $out
refused 1 "give --size and --spacing" p_0001.exr $out --parallel --views 1
refused 1 "needs a turn about an axis" p_0001.exr $out --parallel --views 1 --method fbp
refused 1 "GB; use larger voxels" p.mha $out --parallel --size 16000,16000,16000
refused 1 "GB; use larger voxels" p.mha $out --parallel --size 16000,16000,16000 --method fbp
refused 1 "the reference volume are not where" p.mha $out --parallel $grid --reference apart.vdb
refused 1 "the initial volume are not where" p.mha $out --parallel $grid --initial apart.vdb
refused 1 "the folder 'no' does not exist" p.mha -o no/vol.vdb --parallel
for option in "--plot no/a.svg" "--slices no/a.png" "--report no/a.json"; do
    refused 1 "the folder 'no' does not exist" p.mha $out --parallel $option
done
refused 1 "are the frames swapped?" counts.mha $out --parallel --flat dark.mha --dark flat.mha
refused 1 "the flat frame has" counts.mha $out --parallel --flat c.mha
ct nan.mha --parallel -o repaired.vdb --repair $grid
expect_json report.json "r['input']['values_not_measured'] == 1"
rms_below repaired.vdb 0.0468  # found: 0.0426
ct p_0001.exr --parallel --views 1 -o single.vdb $grid  # a single view is fine where the grid is known

# Usage errors.
cp p.mha before.mha
refused 2 "'p.mha' would be written, but is also projections" p.mha -o p.mha --parallel
refused 2 "'a.xyz' must end in .vdb, .mha, .nrrd, .nii, .nii.gz, or a folder" p.mha -o a.xyz --parallel
refused 2 "--half: is for .vdb" p.mha -o a.mha --parallel --half
refused 2 "holds 'p.mha'" p.mha -o . --parallel
cmp -s p.mha before.mha || fail "ct wrote over its input"
refused 2 "--geometry: is missing" p.mha $out
refused 2 "say it one way only" p.mha $out --parallel --cone 120,180
refused 2 "--output is required" p.mha --parallel
refused 2 "projections is required" $out --parallel
refused 2 "--method" p.mha $out --parallel --method art
refused 2 "whole numbers from 1" p.mha $out --parallel --size 0,0,0
refused 2 "whole numbers from 1" p.mha $out --parallel --size 99999,1,1
refused 2 "--spacing 0: must be positive" p.mha $out --parallel --spacing 0
refused 2 "--spacing 0: must be positive" p.mha $out --parallel --spacing 1,0,1
refused 2 "--spacing -1: must be positive" p.mha $out --parallel --spacing 1,1,-1
refused 2 "one number or three" p.mha $out --parallel --spacing 1,2
refused 2 "--iterations 0: must be at least 1" p.mha $out --parallel --iterations 0
refused 2 "--relaxation 2.5: must be" p.mha $out --parallel --relaxation 2.5
refused 2 "--subset: is for os-sart" p.mha $out --parallel --subset 3
refused 2 "--iterations: is for iterative methods" p.mha $out --parallel --method fbp --iterations 3
refused 2 "'fpb' must be a .vdb file, or fbp" p.mha $out --parallel --initial fpb
refused 2 "--dark: needs --flat as well" counts.mha $out --parallel --dark dark.mha
refused 2 "--rows: of a cone need --center-row as well" cone.h5 $out --cone 120,180 --rows 0,1
refused 2 "--dark: needs --flat as well" scan.h5 $out --flat none --dark 3
refused 2 "--sinograms: HDF5 files say themselves" scan.h5 $out --sinograms
refused 2 "--arc: leave it out if there are --angles" p.mha $out --parallel --arc 180 --angles angles.txt
refused 2 "--saturated-above: of line integrals it is --saturation" p.mha $out --parallel --saturation 9 --saturated-above 9
refused 2 "must be at most --upper" p.mha $out --parallel --nonnegative --upper=-1
refused 2 "--rows: only of HDF5 files" p.mha $out --parallel --rows 0,1
refused 2 "auto is for parallel beams" c.mha $out --cone 120,180 --axis-column auto
refused 2 "must end in .png or .exr" p.mha $out --parallel --slices a.jpg
printf 'bogus = 1\n' >bogus.toml
refused 2 "bogus" p.mha $out --parallel --config bogus.toml
expect_no_leftovers .
expect_exit 0 "$raysweep" ct --help
expect_output "--nonnegative"

# Colour is no line integral.
"$raysweep" light box.vdb -o lit.vdb --sky 1 --tolerance 0.5 --quiet
"$raysweep" render lit.vdb -o colour.png --size 96,40 --quiet
refused 1 "colour.png" colour.png $out --parallel $grid

# A scan of a synchrotron.
tooth=$data/ct/tomopy_tooth.h5
if [ -f "$tooth" ]; then
    ct "$tooth" -o tooth.vdb --method fbp --rows 0,0
    expect_json report.json "abs(r['input']['axis_column'] - 296) <= 1 and r['input']['format'] == 'Data Exchange'"
    expect_json report.json "r['input']['views'] == 181 and r['input']['height'] == 1"
    refused 1 "it has rows 0 to 1" "$tooth" $out --rows 0,5
    head -c 500000 "$tooth" >cut.h5
    refused 1 "cannot read 'cut.h5'" cut.h5 $out
    expect_match "truncated file"
else
    echo "tomopy_tooth.h5 is not on this machine: not tested with it"
fi

finish
