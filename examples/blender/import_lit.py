"""Shows a volume lit by `raysweep light` in Blender, and renders it with Cycles as `raysweep render` does.

    blender -b -P import_lit.py -- LIT.vdb OUT.png|OUT.exr [options]    renders
    blender -P import_lit.py -- LIT.vdb [options]                       opens it, to go on by hand

Run with `-- --help` for the options. What it builds is a scene of its own, called Raysweep, beside whatever is open.
docs/blender.md describes the material in words.
"""

import argparse
import json
import math
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import bpy
from mathutils import Matrix, Vector

MARGIN = 1.05  # around the volume when the camera frames it, as in `raysweep render`


class Problem(Exception):
    """Bad input: what is wrong, where, and what to do."""


# ---------------------------------------------------------------------------------------------- options


def numbers(count):
    def parse(text):
        values = tuple(float(part) for part in text.split(","))
        if len(values) != count or not all(math.isfinite(value) for value in values):
            raise argparse.ArgumentTypeError(f"'{text}': {count} numbers separated by commas are needed")
        return values

    return parse


def color(text):
    values = tuple(float(part) for part in text.split(","))
    if len(values) not in (1, 3) or not all(value >= 0 and math.isfinite(value) for value in values):
        raise argparse.ArgumentTypeError(f"'{text}': one number or R,G,B is needed, not negative")
    return values * 3 if len(values) == 1 else values


def size(text):
    width, height = numbers(2)(text)
    if not (1 <= width == int(width) and 1 <= height == int(height)):
        raise argparse.ArgumentTypeError(f"'{text}': two whole numbers above 0 are needed")
    return int(width), int(height)


def joined(argv):
    """`--eye -1,2,3` as `--eye=-1,2,3`: argparse would take the value for an option."""
    result = []
    for word in argv:
        if result and re.fullmatch(r"--[a-z-]+", result[-1]) and re.match(r"-[\d.]", word):
            result[-1] += "=" + word
        else:
            result.append(word)
    return result


def add_picture_options(parser):
    """What is chosen of a picture, whatever it shows: as for `raysweep render`."""
    parser.add_argument("output", metavar="OUT.png|OUT.exr", nargs="?", help="picture; without it nothing is rendered")
    parser.add_argument("--size", type=size, default=(512, 512), metavar="W,H", help="pixels (512,512)")
    parser.add_argument("--eye", type=numbers(3), metavar="X,Y,Z", help="where the camera stands (so that all is seen)")
    parser.add_argument("--target", type=numbers(3), metavar="X,Y,Z", help="middle of the picture (the volume's)")
    parser.add_argument("--up", type=numbers(3), default=(0, 0, 1), metavar="X,Y,Z", help="up in the picture (0,0,1)")
    lens = parser.add_mutually_exclusive_group()
    lens.add_argument("--fov", type=float, default=40, metavar="DEG", help="vertical field of view, degrees (40)")
    lens.add_argument("--ortho", type=float, metavar="WIDTH", help="parallel projection; width, world units")
    parser.add_argument("--background", type=color, default=(0, 0, 0), metavar="R,G,B", help="linear radiance behind (0)")
    parser.add_argument("--exposure", type=float, default=0, metavar="EV", help="brightness of a .png, stops (0)")
    parser.add_argument("--samples", type=int, default=64, metavar="N", help="rays per pixel (64)")
    parser.add_argument("--step", type=float, default=0.5, metavar="F", help="distance between samples, voxels (0.5)")
    parser.add_argument("--raysweep", metavar="PATH", help="the command raysweep, asked what the file holds (found in "
                        "PATH or in ../../build/bin); not needed if --density, --extinction, --eye and --target are given")
    parser.add_argument("--keep-half-voxel", action="store_true",
                        help="do not make up for the half voxel by which Cycles misplaces volumes")
    parser.add_argument("--density", metavar="NAME", help="density grid (the one that was lit)")
    parser.add_argument("--extinction", type=float, metavar="X", help="extinction per unit density (as it was lit)")


def parse_checked(parser, argv):
    args = parser.parse_args(joined(argv))
    if args.output and Path(args.output).suffix.lower() not in (".png", ".exr"):
        parser.error(f"'{args.output}' must end in .png or .exr")
    if not 0 < args.fov < 180:
        parser.error("--fov must lie between 0 and 180 degrees")
    if args.ortho is not None and not args.ortho > 0:
        parser.error("--ortho must be above 0")
    if args.samples < 1 or not args.step >= 0.01:
        parser.error("--samples must be at least 1 and --step at least 0.01")
    return args


def parse_arguments(argv):
    parser = argparse.ArgumentParser(prog="blender -b -P import_lit.py --", description=__doc__.split("\n")[0])
    parser.add_argument("lit", metavar="LIT.vdb", help="volume written by raysweep light")
    add_picture_options(parser)
    return parse_checked(parser, argv)


# ---------------------------------------------------------------------------------------------- what the file holds


def raysweep(args, *arguments):
    """Runs the command raysweep and returns what it prints; None if it is not to be found."""
    beside = Path(__file__).resolve().parents[2] / "build" / "bin" / "raysweep"
    command = args.raysweep or shutil.which("raysweep") or (str(beside) if beside.exists() else None)
    if command is None:
        return None
    try:
        answer = subprocess.run([command, *arguments], capture_output=True, text=True)
    except OSError as error:
        raise Problem(f"--raysweep: cannot run '{command}': {error.strerror}")
    if answer.returncode != 0:
        raise Problem(answer.stderr.strip() or f"'{command} {arguments[0]}' failed")
    return answer.stdout


def ask_raysweep(args):
    """What the file holds, since Blender cannot read a grid's metadata; None without raysweep, or if all is given."""
    if args.density and args.extinction is not None and args.eye and args.target:
        return None
    answer = raysweep(args, "info", "--json", args.lit)
    return answer and json.loads(answer)


def grid_named(info, name):
    """The first grid of that name, as Blender takes it."""
    return next((grid for grid in info["grids"] if grid["name"] == name), None)


def plain_name(name):
    """`smoke[1]` means the second grid called smoke; Blender reaches only the first."""
    base, bracket, index = name.partition("[")
    if not bracket:
        return name
    if index == "0]":
        return base
    raise Problem(f"'{name}': Blender can only use the first of several grids of the same name; rename it")


class Medium:
    """Which grid gives the extinction, by what factor, which one what is scattered, and which one, if any, what shines by
    itself."""

    source, source_hint = "radiosity", "light it with 'raysweep light'"
    emission = None

    def __init__(self, args, info):
        radiosity = info and grid_named(info, "radiosity")
        lit = radiosity["metadata"] if radiosity else {}
        self.grid = plain_name(args.density or lit.get("raysweep_density", "density"))
        self.factor = lit.get("raysweep_extinction") if args.extinction is None else args.extinction
        # A transfer function leaves the extinction itself in a grid of this name.
        written = info and grid_named(info, "extinction")
        written = written and "raysweep_density" in written["metadata"]  # not one of the user's own
        if written and not args.density and args.extinction is None:
            self.factor = self.factor if self.grid == "extinction" else 1.0
            self.grid = "extinction"
        # One of the user's own is not meant; without raysweep there is no telling.
        fire = info and grid_named(info, "emission")
        if info is None or (fire and "raysweep_density" in fire["metadata"]):
            self.emission = "emission"
        if self.factor is None:
            raise Problem("the extinction per unit density is not known: give --extinction, or --raysweep so that the "
                          "file's metadata can be read")


# ---------------------------------------------------------------------------------------------- the scene


def read_grids(volume, path):
    volume.filepath = str(Path(path).resolve())
    if not volume.grids.load():
        raise Problem(f"Blender cannot read '{path}': {volume.grids.error_message}")
    return volume.grids


def load_volume(args, medium, scene):
    volume = bpy.data.volumes.new(Path(args.lit).stem)
    volume.render.precision = "FULL"
    volume.render.clipping = 0  # else Cycles cuts off what is thin
    grids = read_grids(volume, args.lit)
    for name, hint in ((medium.source, medium.source_hint), (medium.grid, "choose one with --density")):
        if name not in grids:
            raise Problem(f"'{args.lit}' has no grid '{name}': {hint}; it holds {', '.join(sorted(grids.keys()))}")
    if (medium.emission or "") not in grids:
        medium.emission = None
    volume_object = bpy.data.objects.new(volume.name, volume)
    scene.collection.objects.link(volume_object)
    return volume_object


def half_voxel(grid):
    return grid.matrix_object.to_3x3() @ Vector((0.5, 0.5, 0.5))


def move_to_place(args, info, volume_object, medium):
    """Cycles takes voxel (i,j,k) for the cube from (i,j,k) to (i+1,j+1,k+1); in OpenVDB it is the one around (i,j,k).

    So Cycles shows all that it reads half a voxel too far along each axis of the grid (with and without NanoVDB, in all
    versions from 2.81 to 4.x at least). Moving the object back corrects that, unless radiosity has voxels of another
    size, or emission: then each grid has to be moved by its own half voxel, which `raysweep export` does in a copy of the file.
    """
    if args.keep_half_voxel or (info and "raysweep_export" in info["metadata"]):
        return
    grids = volume_object.data.grids
    half = half_voxel(grids[medium.grid])
    others = [name for name in (medium.source, medium.emission) if name]
    if all((half_voxel(grids[name]) - half).length < 1e-3 * half.length for name in others):
        volume_object.location = -half
        return
    # By hand the copy is needed for as long as the scene; else Blender removes it when it ends.
    folder = Path(bpy.app.tempdir) if args.output else Path(args.lit).resolve().parent
    copy = folder / (Path(args.lit).stem + ".blender.vdb")
    if raysweep(args, "export", args.lit, "-o", str(copy)) is None:
        raise Problem(f"the grids of '{args.lit}' have voxels of different sizes, which takes 'raysweep export' to put in "
                      "place: give --raysweep, or light without --resolution or with --upsample")
    read_grids(volume_object.data, copy)


def make_material(medium):
    """L = S (1 - exp(-tau)): what is absorbed, density x extinction, also emits, with radiance S. What shines by itself
    adds its emission, power per volume, over 4 pi."""
    material = bpy.data.materials.new("Lit volume")
    material.use_nodes = True
    material.cycles.volume_interpolation = "LINEAR"
    nodes, link = material.node_tree.nodes, material.node_tree.links.new
    nodes.clear()
    density, radiosity = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeAttribute")
    density.attribute_name, radiosity.attribute_name = medium.grid, medium.source
    extinction = nodes.new("ShaderNodeMath")
    extinction.operation, extinction.inputs[1].default_value = "MULTIPLY", medium.factor
    absorption, emission = nodes.new("ShaderNodeVolumeAbsorption"), nodes.new("ShaderNodeEmission")
    absorption.inputs["Color"].default_value = (0, 0, 0, 1)
    both, output = nodes.new("ShaderNodeAddShader"), nodes.new("ShaderNodeOutputMaterial")
    link(density.outputs["Fac"], extinction.inputs[0])
    link(extinction.outputs[0], absorption.inputs["Density"])
    link(extinction.outputs[0], emission.inputs["Strength"])
    link(radiosity.outputs["Color"], emission.inputs["Color"])
    link(absorption.outputs[0], both.inputs[0])
    link(emission.outputs[0], both.inputs[1])
    link((add_fire(material, medium, both) if medium.emission else both).outputs[0], output.inputs["Volume"])
    for column, row in enumerate(((density, radiosity), (extinction,), (absorption, emission), (both,), (output,))):
        for line, node in enumerate(row):
            node.location = (220 * column, -220 * line)
    return material


def add_fire(material, medium, others):
    """Joins what shines by itself to the shader `others`; returns the node of both."""
    nodes, link = material.node_tree.nodes, material.node_tree.links.new
    color, fire, both = (nodes.new(f"ShaderNode{kind}") for kind in ("Attribute", "Emission", "AddShader"))
    color.attribute_name = medium.emission
    fire.inputs["Strength"].default_value = 1 / (4 * math.pi)
    link(color.outputs["Color"], fire.inputs["Color"])
    link(others.outputs[0], both.inputs[0])
    link(fire.outputs[0], both.inputs[1])
    color.location, fire.location, both.location = (0, -440), (440, -440), (660, -220)
    return both


def make_world(background):
    world = bpy.data.worlds.new("Background")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (*background, 1)
    return world


# ---------------------------------------------------------------------------------------------- the camera


def corners_of(grids):
    """The corners of the box in world space around the active voxels of grids; of a cube if there are none."""
    points = []
    for grid in grids:
        low, high = grid["bounds"]["index"]
        world = Matrix(grid["transform"]["matrix"]).transposed()  # OpenVDB's matrices stand to the right of row vectors
        points += [world @ Vector([(high[a] + 0.5 if corner >> a & 1 else low[a] - 0.5) for a in range(3)])
                   for corner in range(8)]
    points = points or [(-1, -1, -1), (1, 1, 1)]
    lower, upper = ([pick(p[a] for p in points) for a in range(3)] for pick in (min, max))
    return [Vector([(upper if corner >> a & 1 else lower)[a] for a in range(3)]) for corner in range(8)]


def directions(forward, up):
    """Unit vectors to the right and up in the picture."""
    right = forward.cross(up).normalized()
    return right, right.cross(forward)


def framed(args, corners):
    """Eye and target as `raysweep render` chooses them: a three-quarter view from the front, right and above."""
    up = Vector(args.up).normalized()
    axis = Vector((1, 0, 0)) if abs(up.x) < 0.9 else Vector((0, 1, 0))
    across = (axis - up * axis.dot(up)).normalized()
    forward = -(across * 0.5 + across.cross(up) * 0.8 + up * 0.4).normalized()
    target = (corners[0] + corners[7]) / 2
    right, top = directions(forward, up)
    aspect, tangent = args.size[0] / args.size[1], math.tan(math.radians(args.fov) / 2)
    distance = 0
    for p in (corner - target for corner in corners):
        height = max(abs(p.dot(top)), abs(p.dot(right)) / aspect)
        distance = max(distance, MARGIN * height / tangent - p.dot(forward))
    if args.ortho:
        distance = (corners[7] - corners[0]).length
    return target - forward * (distance if distance > 0 else 1), target


def place_camera(args, info, medium, scene):
    eye, target = args.eye and Vector(args.eye), args.target and Vector(args.target)
    if not (eye and target):
        if info is None:
            raise Problem("to frame the volume its size is needed: give --eye and --target, or --raysweep")
        seen = [grid_named(info, name) for name in (medium.grid, medium.emission) if name]
        default_eye, default_target = framed(args, corners_of([grid for grid in seen if "bounds" in grid]))
        target = target or default_target
        eye = eye or target + (default_eye - default_target)
    forward, up = target - eye, Vector(args.up)
    if forward.cross(up).length < 1e-6 * forward.length * up.length or forward.length == 0:
        raise Problem("--up is parallel to the view, or --eye and --target are the same point")
    right, top = directions(forward.normalized(), up)
    lens = bpy.data.cameras.new("Camera")
    if args.ortho:
        lens.type, lens.sensor_fit, lens.ortho_scale = "ORTHO", "HORIZONTAL", args.ortho
    else:
        lens.sensor_fit, lens.angle = "VERTICAL", math.radians(args.fov)
    lens.clip_start, lens.clip_end = 1e-4 * forward.length, 1e4 * forward.length
    camera = bpy.data.objects.new("Camera", lens)
    camera.matrix_world = Matrix.Translation(eye) @ Matrix((right, top, -forward.normalized())).transposed().to_4x4()
    scene.collection.objects.link(camera)
    scene.camera = camera


# ---------------------------------------------------------------------------------------------- rendering


def set_up_rendering(args, scene):
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = *args.size, 100
    render.dither_intensity = 0
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = args.samples, False, False
    cycles.pixel_filter_type = "BOX"
    cycles.max_bounces = cycles.volume_bounces = 0  # all light is in the radiosity already
    cycles.volume_step_rate, cycles.volume_max_steps = args.step, 65536
    scene.display_settings.display_device = "sRGB"
    scene.view_settings.view_transform, scene.view_settings.look = "Standard", "None"
    scene.view_settings.exposure, scene.view_settings.gamma = args.exposure, 1
    linear = bool(args.output) and args.output.lower().endswith(".exr")
    # An .exr over nothing keeps how opaque it is; a .png is what the eye sees.
    render.film_transparent = linear and args.background == (0, 0, 0)
    image = render.image_settings
    image.file_format = "OPEN_EXR" if linear else "PNG"
    image.color_mode, image.color_depth = ("RGBA", "32") if linear else ("RGB", "8")


def render_to(output, scene):
    """Beside the target first: a picture appears whole or not at all."""
    target = Path(output).resolve()
    temporary = target.with_name(f".{target.stem}.part{os.getpid()}{target.suffix}")
    scene.render.filepath, scene.render.use_file_extension = str(temporary), False
    try:
        bpy.ops.render.render(write_still=True, scene=scene.name)
        if not temporary.exists():
            raise Problem(f"cannot write '{output}': look at Blender's messages above")
        os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)


def build(args):
    """A scene with the volume, its material, the camera and the background."""
    if not Path(args.lit).is_file():
        raise Problem(f"there is no file '{args.lit}'")
    info = ask_raysweep(args)
    medium = Medium(args, info)
    scene = bpy.data.scenes.new("Raysweep")
    volume_object = load_volume(args, medium, scene)
    move_to_place(args, info, volume_object, medium)
    volume_object.data.materials.append(make_material(medium))
    scene.world = make_world(args.background)
    place_camera(args, info, medium, scene)
    set_up_rendering(args, scene)
    return scene


def given_arguments():
    return sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []


def finish(args, build):
    """Builds the scene; renders it if that was asked for, else shows it."""
    if args.output and not Path(args.output).resolve().parent.is_dir():
        raise Problem(f"cannot write '{args.output}': its folder does not exist")
    scene = build(args)
    if args.output:
        render_to(args.output, scene)
    elif bpy.context.window:
        bpy.context.window.scene = scene


def run(name, main):
    try:
        main()
    except Problem as problem:
        print(f"{name}: {problem}", file=sys.stderr)
        sys.exit(1)


if __name__ == "__main__":
    run("import_lit", lambda: finish(parse_arguments(given_arguments()), build))
