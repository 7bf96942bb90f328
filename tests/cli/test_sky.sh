# raysweep light --sky FILE: maps of both formats, what is said about them, and what is refused.
source "$(dirname "$0")/lib.sh" "$@"

"$raysweep" generate cloud -o cloud.vdb --size 32
light() { expect_exit 0 "$raysweep" light cloud.vdb --extinction 8 --tolerance 0.1 "$@" --report report.json; }
same_grid() { expect_exit 0 "$raysweep" compare "$1" "$2" --grid "$3" --max-rms 0; }
differs() { expect_exit 1 "$raysweep" compare "$1" "$2" --grid radiosity --max-rms 0.01 && expect_match "is above --max-rms"; }

# hdr FILE WIDTH HEIGHT EXPRESSION: a Radiance picture; EXPRESSION gives r, g, b from u, v in [0,1], v from the top.
hdr() {
    python3 - "$@" <<'PYTHON'
import math, sys
name, width, height, expression = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4]
def rgbe(c):
    largest = max(c)
    if largest < 1e-32: return bytes(4)
    mantissa, exponent = math.frexp(largest)
    return bytes([int(x * mantissa * 256 / largest) for x in c] + [exponent + 128])
with open(name, 'wb') as f:
    f.write(b'#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n' % (height, width))
    for y in range(height):
        for x in range(width):
            f.write(rgbe(eval(expression, {'u': (x + .5) / width, 'v': (y + .5) / height, 'math': math})))
PYTHON
}

# A constant map is a constant sky: EXR as render writes it (alpha is not meant), and HDR.
expect_exit 0 "$raysweep" light cloud.vdb -o lit.vdb --sky 0.25
expect_exit 0 "$raysweep" render lit.vdb -o constant.exr --extinction 0 --background 0.25 --size 64,32
hdr constant.hdr 64 32 "(0.25, 0.25, 0.25)"
light -o number.vdb --sky 0.25
for map in constant.exr constant.hdr; do
    light -o map.vdb --sky $map
    same_grid number.vdb map.vdb radiosity
    expect_json report.json "r['sky_suns'] == 0 and r['sky_suns_share'] == 0 and r['balance_error'] <= 1e-5"
done
light -o map.vdb --sky constant.exr --sky-scale 3
light -o number.vdb --sky 0.75
same_grid number.vdb map.vdb radiosity

# A sun of a few pixels towards +y, a quarter of the width to the left of the middle, 30 degrees up.
hdr sunny.hdr 512 256 "(3000, 2500, 2000) if math.hypot((u - .25) * 2, v - 1/3) < 0.0045 else (0.1, 0.2, 0.4)"
light -o sunny.vdb --sky sunny.hdr
expect_json report.json "r['sky_suns'] == 1 and 0.25 < r['sky_suns_share'] < 0.35 and r['balance_error'] <= 1e-5"
expect_json report.json "any('sky map: 1 sun(s)' in line for line in r['plan'])"
"$raysweep" info sunny.vdb --json >info.json
expect_json info.json "{g['name']: g['type'] for g in r['grids']}['radiosity'] == 'vec3s'"
expect_exit 0 "$raysweep" light cloud.vdb --sky sunny.hdr --explain
expect_output "sky map: 1 sun(s)"
expect_output "direct pass: 1 sun(s)"
expect_output "three wavelengths"
light -o chance.vdb --sky sunny.hdr --sky-suns 0 --sweeps 40
expect_json report.json "r['sky_suns'] == 0"
# The axes: a turn by -90 degrees is a map whose sun is in the middle; another axis up is another light.
hdr middle.hdr 512 256 "(3000, 2500, 2000) if math.hypot((u - .5) * 2, v - 1/3) < 0.0045 else (0.1, 0.2, 0.4)"
light -o turned.vdb --sky sunny.hdr --sky-rotate -90
light -o middle.vdb --sky middle.hdr
expect_exit 0 "$raysweep" compare turned.vdb middle.vdb --grid radiosity --max-rms 1e-5
differs sunny.vdb turned.vdb
for up in x y; do
    light -o up.vdb --sky sunny.hdr --sky-up $up
    differs sunny.vdb up.vdb
done
light -o up.vdb --sky sunny.hdr --sky-up z
same_grid sunny.vdb up.vdb radiosity
# Towards +y, 30 degrees up: light travels along 0,-cos,-sin. The sun's own share is what is lit directly.
hdr only.hdr 512 256 "(3000, 3000, 3000) if math.hypot((u - .25) * 2, v - 1/3) < 0.0045 else (0, 0, 0)"
light -o only.vdb --sky only.hdr --sweeps 0
expect_json report.json "r['sky_suns'] == 1 and r['sky_suns_share'] > 0.999"
light -o sun.vdb --sun 0,-0.8660254,-0.5,1 --sweeps 0
python3 - only.vdb sun.vdb "$raysweep" <<'PYTHON' || fail "the map's sun does not light as a sun from there"
import json, math, subprocess, sys
def top(path):
    grids = json.loads(subprocess.run([sys.argv[3], 'info', path, '--json'], capture_output=True, check=True).stdout)
    return next(g['max'][0] for g in grids['grids'] if g['name'] == 'radiosity')
# 3000 is 2992 in the format, and 4 times the mean of the sphere, a thousandth, is left to the sky.
w, h = 512, 256
sun = [y for y in range(h) for x in range(w) if math.hypot(((x + .5) / w - .25) * 2, (y + .5) / h - 1 / 3) < 0.0045]
irradiance = sum(2992 * 2 * math.pi / w * (math.cos(math.pi * y / h) - math.cos(math.pi * (y + 1) / h)) for y in sun)
ratio = top(sys.argv[1]) / (top(sys.argv[2]) * irradiance)
assert abs(ratio - 1) < 0.005, ratio
PYTHON

# The options make the same again.
"$raysweep" info turned.vdb --json >info.json
json info.json "{g['name']: g for g in r['grids']}['radiosity']['metadata']['raysweep_options']" >again.toml
expect_exit 0 "$raysweep" light --config again.toml -o again.vdb
same_grid turned.vdb again.vdb radiosity

# What is refused.
refuse() {
    local code=$1 text=$2
    shift 2
    expect_exit "$code" "$raysweep" light cloud.vdb -o x.vdb "$@"
    expect_match "$text"
    [ ! -e x.vdb ] || fail "an output appeared"
}
refuse 2 "'bright' is neither a radiance" --sky bright
expect_match "0.5,0.7,1"
expect_match "sky.exr"
refuse 2 "must not be negative" --sky -1
refuse 2 "one number or three" --sky 1,2
refuse 2 "neither a radiance" --sky nan
refuse 1 "--sky: cannot read 'missing.exr': there is no such file" --sky missing.exr
echo "no picture at all" >text.exr
refuse 1 "--sky: cannot read 'text.exr'" --sky text.exr
head -c 3000 sunny.hdr >cut.hdr
refuse 1 "--sky: cannot read 'cut.hdr'" --sky cut.hdr
refuse 1 "it is an OpenVDB volume" --sky cloud.vdb
refuse 1 "folder" --sky .
hdr square.hdr 64 64 "(1, 1, 1)"
refuse 1 "--sky: 'square.hdr': a sky map must be a lat-long picture, twice as wide as high; this one has 64 x 64" --sky square.hdr
hdr small.hdr 2 1 "(1, 1, 1)"
refuse 1 "at least 4 x 2 pixels" --sky small.hdr
refuse 2 "--sky-up" --sky 1 --sky-up w
refuse 2 "--sky-suns" --sky 1 --sky-suns -1
refuse 2 "--sky-suns" --sky 1 --sky-suns 2000
refuse 2 "--sky-rotate" --sky 1 --sky-rotate nan
refuse 2 "--sky-scale" --sky 1 --sky-scale -1

finish
