# raysweep import: files of other programs, made here with Python's standard library, become volumes; bad ones are
# refused with a message and leave nothing behind.
source "$(dirname "$0")/lib.sh" "$@"

python3 - <<'END'
import struct, zlib

labels = bytes(1 + i + 4 * j + 16 * k for k in range(5) for j in range(4) for i in range(4))  # 4x4x5, none is 0
nrrd = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 5\nspacings: 1 2 3\nencoding: %s\n\n"
open("a.nrrd", "wb").write(nrrd % b"raw" + labels)
open("cut.nrrd", "wb").write(nrrd % b"raw" + labels[:-1])
open("header.nrrd", "wb").write(nrrd.replace(b"uint8", b"word") % b"raw" + labels)
open("a.raw", "wb").write(labels)
open("rgb.nrrd", "wb").write(nrrd.replace(b"dimension: 3\nsizes: 4 4 5\nspacings: 1 2 3", b"dimension: 4\nsizes: 4 5 2 2") % b"raw"
                             + labels)
open("second.raw", "wb").write(labels[40:])
meta = b"NDims = 3\nDimSize = 4 5 2\nElementType = MET_UCHAR\n"
open("colour.mha", "wb").write(meta + b"ElementNumberOfChannels = 2\nElementDataFile = LOCAL\n" + labels)
open("quantized.nrrd", "wb").write(nrrd.replace(b"encoding", b"old min: -1\nold max: 1\nencoding") % b"raw" + labels)
open("printf.mhd", "wb").write(meta + b"ElementDataFile = %s%n%d 1 100000000 1\n")
open("dimensions.mha", "wb").write(b"NDims = 1e300\n" + meta[10:] + b"ElementDataFile = LOCAL\n" + labels)
open("line.nrrd", "wb").write(b"NRRD0004\n" + b"1.0 2.0 " * 1000 + b"\n")
bomb = zlib.compressobj(9, zlib.DEFLATED, 31)
open("bomb.nrrd", "wb").write(nrrd.replace(b"sizes: 4 4 5", b"sizes: 4000 4000 4000") % b"gzip"
                              + bomb.compress(bytes(1 << 22)) + bomb.flush())
open("large.nrrd", "wb").write(nrrd.replace(b"sizes: 4 4 5", b"sizes: 400000 400000 5") % b"raw" + labels)
open("endless.nhdr", "wb").write(nrrd[:-1].replace(b"%s", b"raw\ndata file: /dev/zero"))
open("itself.nhdr", "wb").write(nrrd[:-1].replace(b"%s", b"raw\ndata file: itself.nhdr"))
open("swapped.raw", "wb").write(b"HEAD" + b"".join(struct.pack(">H", b) for b in labels))
open("nan.raw", "wb").write(struct.pack("<8f", 1, 2, 3, float("nan"), 5, 6, 7, 8))

def png(name, width, height, samples):  # 16 bit grey
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + struct.pack(">%dH" % width, *samples[y * width:(y + 1) * width]) for y in range(height))
    open(name, "wb").write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0))
                           + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))

for k in range(12):  # slice10 must come after slice9
    png("slice%d.png" % k, 3, 2, [1000 * k + n + 1 for n in range(6)])
png("large.png", 4, 4, [1] * 16)
open("stack.raw", "wb").write(b"".join(struct.pack("<H", 1000 * k + n + 1) for k in range(12) for n in range(6)))
END
mkdir empty stack && mv slice*.png stack

# Two ways to the same volume: pictures of a folder, or named one by one, and raw samples.
expect_exit 0 "$raysweep" import stack -o stack.vdb --report stack.json
expect_json stack.json "r['dims'] == [3, 2, 12] and r['type'] == 'uint16' and r['range'] == [1, 11006]"
expect_json stack.json "r['voxels_active'] == 72 and r['seconds'] >= 0 and r['spacing'] == [1, 1, 1]"
expect_exit 0 "$raysweep" import stack/*.png -o named.vdb
expect_exit 0 "$raysweep" compare named.vdb stack.vdb --max-rms 0
expect_exit 0 "$raysweep" import stack.raw --dims 3,2,12 --type uint16 -o raw.vdb
expect_exit 0 "$raysweep" compare raw.vdb stack.vdb --max-rms 0

# Values: [0,1] by default, the file's numbers on request; scale and offset mean the file's numbers.
raw="import a.raw --dims 4,4,5 --type uint8"
range_of() {
    expect_exit 0 "$raysweep" info "$1" --json
    cp .out info.json
}
expect_exit 0 "$raysweep" $raw -o a.vdb
range_of a.vdb
expect_json info.json "abs(r['grids'][0]['max'][0] - 80 / 255) < 1e-7"
expect_exit 0 "$raysweep" $raw -o a.vdb --normalize none
range_of a.vdb
expect_json info.json "r['grids'][0]['min'] == [1] and r['grids'][0]['max'] == [80]"
expect_exit 0 "$raysweep" $raw -o a.vdb --scale 2 --offset=-100 --name ct --half
range_of a.vdb
expect_json info.json "r['grids'][0]['min'] == [-98] and r['grids'][0]['max'] == [60]"
expect_json info.json "r['grids'][0]['name'] == 'ct'"
expect_exit 0 "$raysweep" $raw -o a.vdb --normalize none --tolerance 16 --report a.json
expect_json a.json "r['voxels_active'] == 64"
expect_exit 0 "$raysweep" $raw -o a.vdb --crop 1,0,4,3,3,4 --report a.json
expect_json a.json "r['voxels_active'] == 12 and r['range'] == [66, 80]"
expect_exit 0 "$raysweep" import swapped.raw --dims 4,4,5 --type uint16 --big-endian --skip 4 -o b.vdb --normalize data
expect_exit 0 "$raysweep" $raw -o a.vdb --normalize data
expect_exit 0 "$raysweep" compare a.vdb b.vdb --max-rms 0
expect_exit 0 "$raysweep" import swapped.raw --dims 4,4,5 --type uint16 --big-endian --skip 4 -o b.vdb
expect_match "--normalize data"
expect_exit 0 "$raysweep" import nan.raw --dims 2,2,2 --type float -o repaired.vdb --repair --report nan.json
expect_json nan.json "r['voxels_repaired'] == 1 and r['voxels_active'] == 7"

# Formats with a header.
expect_exit 0 "$raysweep" import a.nrrd -o nrrd.vdb --report nrrd.json
expect_json nrrd.json "r['format'] == 'NRRD' and r['dims'] == [4, 4, 5] and r['spacing'] == [1, 2, 3]"
expect_exit 0 "$raysweep" $raw -o a.vdb --spacing 1,2,3
expect_exit 0 "$raysweep" compare nrrd.vdb a.vdb --max-rms 0
expect_exit 1 "$raysweep" import cut.nrrd -o bad.vdb
expect_match "'cut.nrrd': its data end too early: 80 bytes of samples are needed, there are 79"
expect_exit 1 "$raysweep" import header.nrrd -o bad.vdb
expect_match "word"
engine=$data/volumes/engine.nrrd
if [ -f "$engine" ]; then
    python3 -c "
import gzip, sys
data = open(sys.argv[1], 'rb').read()
samples = gzip.decompress(data[data.index(b'\n\n') + 2:])
open('engine.raw', 'wb').write(samples)
print(sum(1 for s in samples if s), max(samples))" "$engine" >engine.txt
    read -r active top <engine.txt
    expect_exit 0 "$raysweep" import "$engine" -o engine.vdb --report engine.json
    expect_json engine.json "r['dims'] == [256, 256, 128] and r['voxels_active'] == $active and r['range'] == [0, $top]"
    expect_exit 0 "$raysweep" import engine.raw --dims 256,256,128 --type uint8 -o raw.vdb
    expect_exit 0 "$raysweep" compare engine.vdb raw.vdb --max-rms 0
else
    echo "engine.nrrd is not on this machine: not tested with it"
fi
if ! has_itk; then
    echo nothing >a.dcm
    expect_exit 1 "$raysweep" import a.dcm -o bad.vdb
    expect_match "has no ITK"
fi

# A file that holds several channels or volumes is refused with the list of them; options choose one.
expect_exit 1 "$raysweep" import rgb.nrrd -o bad.vdb
expect_match "'rgb.nrrd' holds 2 volumes of 4x5x2"
expect_match "choose one by --volume-index: 0 to 1"
expect_exit 1 "$raysweep" import rgb.nrrd -o bad.vdb --volume-index 1 --channel 2
expect_match "--channel 2: 'rgb.nrrd' holds one, which has the number 0"
expect_exit 0 "$raysweep" import rgb.nrrd -o second.vdb --volume-index 1
expect_exit 0 "$raysweep" import second.raw --dims 4,5,2 --type uint8 -o raw.vdb
expect_exit 0 "$raysweep" compare second.vdb raw.vdb --max-rms 0
expect_exit 1 "$raysweep" import colour.mha -o bad.vdb
expect_match "'colour.mha' holds 2 channels, but a volume needs one number per voxel; choose one by --channel: 0 to 1"
expect_exit 0 "$raysweep" import colour.mha -o odd.vdb --channel 1 --normalize none --report odd.json
expect_json odd.json "r['range'] == [2, 80] and r['unit'] == 'mm' and r['notes'] == []"
expect_exit 2 "$raysweep" import colour.mha -o bad.vdb --channel=-1
expect_match "--channel -1: must be 0 or larger"
expect_exit 1 "$raysweep" import a.raw --dims 4,4,5 --type uint8 --volume-index 1 -o bad.vdb
expect_match "--volume-index 1"

# What must not pass without a word is said, and is in the report.
expect_exit 0 "$raysweep" import quantized.nrrd -o a.vdb --report a.json
expect_match "old min"
expect_json a.json "len(r['notes']) == 1"

# Files that are not to be trusted: soon, and in little memory.
ln -s /dev/zero zero.nrrd && ln -s /dev/zero zero.mha && ln -s /dev/zero zero.nii && ln -s /dev/zero zero.dcm
ln -s /dev/zero zero.tif && ln -s /dev/zero zero.raw && ln -s /dev/zero zero.exr && mkfifo pipe.nrrd
for file in zero.nrrd zero.mha zero.nii zero.dcm zero.tif zero.exr pipe.nrrd; do
    expect_exit 1 timeout 20 "$raysweep" import $file -o bad.vdb
    expect_match "it is a device or a pipe"
done
expect_exit 1 timeout 20 "$raysweep" import zero.raw --dims 4,4,4 --type uint8 -o bad.vdb
expect_match "it is a device or a pipe"
for file in printf.mhd dimensions.mha line.nrrd bomb.nrrd large.nrrd endless.nhdr itself.nhdr; do
    expect_exit 1 timeout 20 "$raysweep" import $file -o bad.vdb
    expect_match "cannot read '$file'"
done

# What cannot be imported.
expect_exit 1 "$raysweep" import missing.nrrd -o bad.vdb
expect_match "missing.nrrd': there is no such file"
expect_exit 1 "$raysweep" import a.raw -o bad.vdb
expect_match "--dims X,Y,Z and --type"
expect_exit 1 "$raysweep" import a.raw --dims 4,4,6 --type uint8 -o bad.vdb
expect_match "it would fit dims 4,4,5 of uint8"
expect_exit 1 "$raysweep" import nan.raw --dims 2,2,2 --type float -o bad.vdb
expect_match "(1, 1, 0)"
expect_match "--repair"
expect_exit 1 "$raysweep" import repaired.vdb -o bad.vdb
expect_match "it is a .vdb already; 'raysweep light' takes it as it is"
expect_exit 1 "$raysweep" import empty -o bad.vdb
expect_match "no files at all"
expect_exit 1 "$raysweep" import stack/slice1.png large.png -o bad.vdb
expect_match "slice1.png': its size is 3x2, but the first picture's is 4x4"
expect_exit 1 "$raysweep" $raw -o bad.vdb --crop 0,0,0,4,3,4
expect_match "last voxel is (3, 3, 4)"
expect_exit 1 "$raysweep" $raw -o no/such/folder.vdb
expect_match "does not exist"
[ ! -e bad.vdb ] || fail "an error wrote a file"
expect_no_leftovers .

# Usage errors.
expect_exit 2 "$raysweep" import -o a.vdb
expect_exit 2 "$raysweep" import a.raw -o -
expect_exit 2 "$raysweep" import a.raw -o bad.vdb --dims 4,4,5
expect_match "--type"
expect_exit 2 "$raysweep" import a.raw -o bad.vdb --type uint8
expect_match "--dims"
expect_exit 2 "$raysweep" import a.raw -o bad.vdb --dims 4,4,5 --type byte
expect_match "uint16"
expect_exit 2 "$raysweep" import a.raw -o bad.vdb --dims 4,4.5,5 --type uint8
expect_exit 2 "$raysweep" import a.nrrd -o bad.vdb --big-endian
expect_exit 2 "$raysweep" $raw -o bad.vdb --tolerance=-1
expect_match "--tolerance -1: must be finite"
expect_exit 2 "$raysweep" $raw -o bad.vdb --spacing 1,0,1
expect_match "--spacing 0: must be larger than 0"
expect_exit 2 "$raysweep" $raw -o bad.vdb --crop 2,0,0,1,3,3
expect_exit 2 "$raysweep" $raw -o bad.vdb --normalize half
expect_exit 0 "$raysweep" import --help
expect_output "--tolerance"

finish
