# Blender shows baked meshes: the colours that its importer finds are those that raysweep bake found.
here=$(cd "$(dirname "$0")" && pwd)
source "$here/../cli/lib.sh" "$@"

if ! command -v blender >/dev/null; then
    echo "skipped: blender is not here (scripts/setup.sh --tests installs it)"
    exit 77
fi

python3 - <<'END'
n = 8  # a floor of 8x8 squares
with open("floor.obj", "w") as f:
    f.writelines("v %g %g 0\n" % (x, y) for y in range(n + 1) for x in range(n + 1))
    for a in (y * (n + 1) + x + 1 for y in range(n) for x in range(n)):
        f.write("f %d %d %d %d\n" % (a, a + 1, a + n + 2, a + n + 1))
END
expect_exit 0 "$raysweep" import floor.obj -o floor.vdb --size 32
expect_exit 0 "$raysweep" light floor.vdb -o lit.vdb --ramp 0,1 --albedo 0.9,0.6,0.3 --point 2,3,2,30 --quiet
expect_exit 0 "$raysweep" bake lit.vdb floor.obj -o shown.ply
expect_exit 0 "$raysweep" bake lit.vdb floor.obj -o exact.ply --colors linear
cat >compare.py <<'END'
import bpy, addon_utils, struct
bpy.ops.wm.read_factory_settings(use_empty=True)
addon_utils.enable("io_mesh_ply")
bpy.ops.import_mesh.ply(filepath="shown.ply")
mesh = bpy.context.selected_objects[0].data
header, body = open("exact.ply", "rb").read().split(b"end_header\n", 1)
exact = {}
for i in range(len(mesh.vertices)):
    v = struct.unpack_from("<9f", body, 36 * i)
    exact[tuple(v[:3])] = v[6:]
assert len(mesh.vertices) == len(exact) == 81
worst = 0
for loop, colour in zip(mesh.loops, mesh.color_attributes[0].data):
    for shown, wanted in zip(colour.color, exact[tuple(mesh.vertices[loop.vertex_index].co)]):
        worst = max(worst, abs(shown - min(1, wanted)))
assert worst < 0.005, worst  # half a step of 255 is 0.0045 of linear light near white
print("brightest", max(max(c) for c in exact.values()), "worst", worst)
END
expect_exit 0 blender -b --python-exit-code 3 -P compare.py
finish
