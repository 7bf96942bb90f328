"""Shows a volume that `raysweep photo` made of photographs in Blender, and renders it with Cycles.

    blender -b -P import_reconstruction.py -- VOL.vdb OUT.png|OUT.exr [options]    renders
    blender -P import_reconstruction.py -- VOL.vdb [options]                       opens it, to go on by hand

Without more it looks as it was photographed, as `raysweep render` shows it: colours shine, no light is computed. With
--relight colours are what scatters, and a sun and the background are the light. Run with `-- --help` for the options.
docs/photographs.md describes the materials in words. Stands on import_lit.py beside it.
"""

import argparse
import math
import sys
from pathlib import Path

import bpy
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).resolve().parent))
import import_lit as lit  # noqa: E402


def parse_arguments(argv):
    parser = argparse.ArgumentParser(prog="blender -b -P import_reconstruction.py --",
                                     description=__doc__.split("\n")[0])
    parser.add_argument("lit", metavar="VOL.vdb", help="volume written by raysweep photo")
    lit.add_picture_options(parser)
    parser.add_argument("--relight", action="store_true", help="light it anew, with its colours as albedo")
    parser.add_argument("--sun", type=lit.numbers(4), default=(0.3, 1, -0.8, 3), metavar="X,Y,Z,E",
                        help="--relight: direction in which its light travels, and irradiance (0.3,1,-0.8,3)")
    parser.add_argument("--bounces", type=int, default=8, metavar="N", help="--relight: scatterings that are followed (8)")
    args = lit.parse_checked(parser, argv)
    if not Vector(args.sun[:3]).length > 0 or not args.sun[3] >= 0:
        parser.error("--sun needs a direction that is not 0,0,0, and an irradiance that is not negative")
    if args.bounces < 0:
        parser.error("--bounces must not be negative")
    return args


class Reconstruction:
    """Extinction is the density itself, and the colours shine."""

    source, source_hint = "Cd", "it is no volume of raysweep photo"
    emission = None

    def __init__(self, args):
        self.grid = lit.plain_name(args.density or "density")
        self.factor = 1.0 if args.extinction is None else args.extinction


def make_scattering_material(medium):
    """Cd is the albedo: Principled Volume scatters density x colour, and absorbs the rest."""
    material = bpy.data.materials.new("Reconstruction, lit anew")
    material.use_nodes = True
    material.cycles.volume_interpolation = "LINEAR"
    nodes, link = material.node_tree.nodes, material.node_tree.links.new
    nodes.clear()
    density, color = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeAttribute")
    density.attribute_name, color.attribute_name = medium.grid, medium.source
    extinction = nodes.new("ShaderNodeMath")
    extinction.operation, extinction.inputs[1].default_value = "MULTIPLY", medium.factor
    volume, output = nodes.new("ShaderNodeVolumePrincipled"), nodes.new("ShaderNodeOutputMaterial")
    volume.inputs["Density Attribute"].default_value = ""  # else the grid density is multiplied in once more
    link(density.outputs["Fac"], extinction.inputs[0])
    link(extinction.outputs[0], volume.inputs["Density"])
    link(color.outputs["Color"], volume.inputs["Color"])
    link(volume.outputs[0], output.inputs["Volume"])
    for column, row in enumerate(((density, color), (extinction,), (volume,), (output,))):
        for line, node in enumerate(row):
            node.location = (220 * column, -220 * line)
    return material


def add_sun(args, scene):
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = args.sun[3], math.radians(0.5)
    sun_object = bpy.data.objects.new("Sun", sun)
    sun_object.rotation_euler = Vector(args.sun[:3]).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(sun_object)


def build(args):
    """A scene with the volume, its material, the camera, and the background."""
    if not Path(args.lit).is_file():
        raise lit.Problem(f"there is no file '{args.lit}'")
    info = lit.ask_raysweep(args)
    medium = Reconstruction(args)
    scene = bpy.data.scenes.new("Raysweep")
    volume_object = lit.load_volume(args, medium, scene)
    lit.move_to_place(args, info, volume_object, medium)
    material = make_scattering_material(medium) if args.relight else lit.make_material(medium)
    volume_object.data.materials.append(material)
    scene.world = lit.make_world(args.background)
    lit.place_camera(args, info, medium, scene)
    lit.set_up_rendering(args, scene)
    if args.relight:
        add_sun(args, scene)
        scene.cycles.max_bounces = scene.cycles.volume_bounces = args.bounces
    return scene


if __name__ == "__main__":
    lit.run("import_reconstruction", lambda: lit.finish(parse_arguments(lit.given_arguments()), build))
