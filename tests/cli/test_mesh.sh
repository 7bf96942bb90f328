# raysweep import of meshes and raysweep bake: a room of meshes becomes a volume, is lit, and its light goes back onto
# the meshes.
source "$(dirname "$0")/lib.sh" "$@"

python3 - <<'END'
def box(name, low, high, colour=""):
    corners = [tuple((high if c >> a & 1 else low)[a] for a in range(3)) for c in range(8)]
    text = "".join("v %g %g %g%s\n" % (p + (colour,)) for p in corners)
    faces = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))
    open(name, "w").write(text + "".join("f %d %d %d %d\n" % tuple(i + 1 for i in f) for f in faces))

box("block.obj", (4, 4, 1), (8, 8, 5), " 1 0 0")
box("far.obj", (40, 4, 1), (44, 8, 5))
open("floor.obj", "w").write("v 0 0 0\nv 16 0 0\nv 16 16 0\nv 0 16 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n")
open("hole.obj", "w").write(open("block.obj").read().replace("f 5 6 8 7\n", ""))
open("points.ply", "w").write("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                              "property float z\nend_header\n0 0 0\n")
END

expect_exit 0 "$raysweep" import block.obj -o block.vdb --voxel-size 0.25 --report block.json
expect_silent
expect_json block.json "r['solids'] == 1 and r['voxels_active'] == 16**3 and r['colours'] and r['voxel_size'] == 0.25"
expect_exit 0 "$raysweep" import block.obj -o size.vdb --size 16
expect_exit 0 "$raysweep" compare size.vdb block.vdb --max-rms 0
expect_exit 0 "$raysweep" import hole.obj -o hole.vdb --voxel-size 0.25 --report hole.json
expect_match "1 open surface was taken as sheets of 2 voxels: 4 edges have one triangle only, in 1 rim or hole"
expect_json hole.json "r['solids'] == 0 and r['sheets'] == 1 and r['open_edges'] == 4"

# A scene, its light, and the light on its parts.
expect_exit 2 "$raysweep" import block.obj floor.obj -o scene.vdb
expect_match "--merge"
expect_exit 0 "$raysweep" import block.obj floor.obj --merge -o scene.vdb --voxel-size 0.25 --name walls
expect_exit 0 "$raysweep" light scene.vdb -o lit.vdb --density walls --ramp 0,1 --albedo grid:Cd --sun 0.5,0.6,-1,3 --sky 0.5 --quiet
expect_exit 0 "$raysweep" bake lit.vdb floor.obj -o floor.ply --atlas 32 --exposure -1 --report floor.json
expect_silent
expect_json floor.json "r['corners'] == {'places': 4, 'turned': 0, 'missed': 0} and r['texels']['places'] == 1024"
expect_exit 0 "$raysweep" bake lit.vdb block.obj -o block.ply --colors linear
# Red stays red: what the white floor sends it has no green or blue.
python3 - <<'END' || fail "colours of block.ply"
import struct
data = open("block.ply", "rb").read()
header, body = data.split(b"end_header\n", 1)
vertices = [struct.unpack_from("<9f", body, 36 * i) for i in range(8)]
assert all(v[6] > 0.05 and v[7] == 0 and v[8] == 0 for v in vertices), vertices
END
expect_exit 0 "$raysweep" bake lit.vdb block.obj -o shown.ply
expect_match "brighter than a display's white"
expect_exit 0 "$raysweep" bake lit.vdb block.obj -o shown.ply --exposure -2
expect_silent
expect_exit 2 "$raysweep" bake lit.vdb block.obj -o x.ply --colors linear --exposure 1

# What is not where the volume is, is black and said to be.
expect_exit 0 "$raysweep" import floor.obj -o floor.vdb --size 8
expect_exit 0 "$raysweep" light floor.vdb -o floor_lit.vdb --ramp 0,1 --sky 1 --quiet
expect_exit 0 "$raysweep" bake floor_lit.vdb far.obj -o missed.ply
expect_match "8 of 8 corners of the mesh lie where the volume has next to nothing"

# Bad input leaves nothing.
expect_exit 1 "$raysweep" import none.obj -o x.vdb
expect_match "cannot read 'none.obj': there is no such file"
expect_exit 1 "$raysweep" import points.ply -o x.vdb
expect_match "cannot read 'points.ply'"
expect_exit 2 "$raysweep" import block.obj -o x.vdb --scale 2
expect_match "--scale: means nothing to meshes"
expect_exit 2 "$raysweep" import points.raw --dims 1,1,1 --type uint8 -o x.vdb --thickness 3
expect_match "--thickness: is for meshes"
expect_exit 2 "$raysweep" import block.obj -o x.vdb --voxel-size 0
expect_match "--voxel-size 0: must be finite and above 0"
expect_exit 1 "$raysweep" import block.obj -o x.vdb --voxel-size 1e-6
expect_match "65536 voxels"
expect_exit 1 "$raysweep" bake lit.vdb block.obj -o x.ply --atlas 8
expect_match "--atlas: the mesh has no texture coordinates"
expect_exit 1 "$raysweep" bake floor.vdb floor.obj -o x.ply
expect_match "has no grid 'radiosity'"
expect_exit 2 "$raysweep" bake lit.vdb floor.obj -o x.obj
expect_match "give a name with .ply"

# Ctrl-C stops the conversion, which would take a minute, in the middle of it.
start_interruptible "$raysweep" import block.obj -o x.vdb --size 1500
interrupt_after_work $!
[ $? = 130 ] || fail "exit code after Ctrl-C"
expect_match "stopped; nothing was written"
[ ! -e x.vdb ] && [ ! -e x.ply ] && [ ! -e x.exr ] || fail "output of a failed run"
expect_no_leftovers .
finish
