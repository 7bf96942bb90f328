"""A cloud as Blender Cycles renders it, with all scattering: how long, how noisy, how bright.

    blender -b --python-exit-code 3 -P cycles_render.py -- SCENE.json RESULT.json

SCENE.json says what the scene is, in the words of `raysweep light` and `raysweep render` (bench/quality/cycles.sh writes
it). Each number of samples is rendered twice, with two seeds: two renders of one noise differ by the square root of two
times the noise, whatever the picture they converge to.
"""

import json
import math
import sys
import time
from pathlib import Path

import bpy
import numpy
from mathutils import Matrix, Vector

SILHOUETTE = 0.01  # least opacity of a pixel that sees the cloud


def load_cloud(setup, scene):
    volume = bpy.data.volumes.new("Cloud")
    volume.render.precision = "FULL"
    volume.render.clipping = 0  # else Cycles cuts off what is thin
    volume.filepath = setup["volume"]
    if not volume.grids.load():
        raise RuntimeError(volume.grids.error_message)
    cloud = bpy.data.objects.new("Cloud", volume)
    # Cycles shows volumes half a voxel too far along each axis (docs/blender.md).
    cloud.location = -(volume.grids["density"].matrix_object.to_3x3() @ Vector((0.5, 0.5, 0.5)))
    scene.collection.objects.link(cloud)
    volume.materials.append(make_material(setup))


def make_material(setup):
    """Extinction is density x extinction; the part `albedo` of what collides is scattered evenly, the rest absorbed."""
    material = bpy.data.materials.new("Cloud")
    material.use_nodes = True
    material.cycles.volume_interpolation = "LINEAR"
    nodes, link = material.node_tree.nodes, material.node_tree.links.new
    nodes.clear()
    density, extinction = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeMath")
    density.attribute_name = "density"
    extinction.operation, extinction.inputs[1].default_value = "MULTIPLY", setup["extinction"]
    link(density.outputs["Fac"], extinction.inputs[0])
    both, output = nodes.new("ShaderNodeAddShader"), nodes.new("ShaderNodeOutputMaterial")
    # Scattering has the coefficient colour x density, absorption (1 - colour) x density.
    for socket, kind in enumerate(("ShaderNodeVolumeScatter", "ShaderNodeVolumeAbsorption")):
        node = nodes.new(kind)
        node.inputs["Color"].default_value = (*[setup["albedo"]] * 3, 1)
        link(extinction.outputs[0], node.inputs["Density"])
        link(node.outputs[0], both.inputs[socket])
    link(both.outputs[0], output.inputs["Volume"])
    return material


def add_lights(setup, scene):
    *direction, irradiance = setup["sun"]
    lamp = bpy.data.lights.new("Sun", "SUN")
    lamp.energy, lamp.angle = irradiance, 0
    sun = bpy.data.objects.new("Sun", lamp)
    sun.rotation_euler = Vector(direction).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(sun)
    scene.world = bpy.data.worlds.new("Sky")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    background.inputs["Strength"].default_value = setup["sky"]


def place_camera(setup, scene):
    camera = setup["camera"]
    eye, forward = Vector(camera["eye"]), (Vector(camera["target"]) - Vector(camera["eye"])).normalized()
    right = forward.cross(Vector(camera["up"])).normalized()
    lens = bpy.data.cameras.new("Camera")
    lens.sensor_fit, lens.angle = "VERTICAL", math.radians(camera["fov"])
    lens.clip_start, lens.clip_end = 1e-4, 1e4
    placed = bpy.data.objects.new("Camera", lens)
    placed.matrix_world = Matrix.Translation(eye) @ Matrix((right, right.cross(forward), -forward)).transposed().to_4x4()
    scene.collection.objects.link(placed)
    scene.camera = placed
    scene.render.resolution_x, scene.render.resolution_y = camera["width"], camera["height"]


def set_up_rendering(setup, scene):
    render, cycles = scene.render, scene.cycles
    render.engine, render.resolution_percentage = "CYCLES", 100
    render.threads_mode, render.threads = "FIXED", setup["threads"]
    render.film_transparent = True  # the sky lights, but is not seen: as raysweep renders
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.pixel_filter_type = "BOX"
    cycles.max_bounces = cycles.volume_bounces = setup["bounces"]
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0  # clamping would darken
    cycles.light_sampling_threshold = 0
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode, render.image_settings.color_depth = "RGBA", "32"


def load(path):
    """Height x width x RGBA, row 0 at the bottom."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"  # the values as stored
    values = numpy.empty(image.size[0] * image.size[1] * 4, numpy.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4).astype(float)


def render_once(scene, folder, samples, seed):
    """The picture and the seconds it took, with all that Cycles does before its first sample."""
    path = folder / f"cycles_{samples}_{seed}.exr"
    scene.cycles.samples, scene.cycles.seed = samples, seed
    scene.render.filepath, scene.render.use_file_extension = str(path), False
    start = time.perf_counter()
    bpy.ops.render.render(write_still=True, scene=scene.name)
    return load(path), time.perf_counter() - start


def grey(picture, seen):
    return picture[seen][:, :3].mean(axis=1)


def measure(setup, scene, folder):
    reference = load(setup["picture"])
    seen = reference[..., 3] > SILHOUETTE
    runs, pictures, weights = [], [], []
    render_once(scene, folder, 1, 1)  # the first one also loads the kernels
    for samples in setup["samples"]:
        (one, seconds_one), (two, seconds_two) = (render_once(scene, folder, samples, seed) for seed in (1, 2))
        a, b = grey(one, seen), grey(two, seen)
        noise = math.sqrt(((a - b) ** 2).mean() / 2) / math.sqrt((0.25 * (a + b) ** 2).mean())
        runs.append({"samples": samples, "seconds": [seconds_one, seconds_two], "noise": noise})
        pictures += [one, two]
        weights += [samples, samples]
    mean = numpy.average(pictures, axis=0, weights=weights)
    return {
        "runs": runs,
        "pixels": int(seen.sum()),
        "mean": float(grey(mean, seen).mean()),
        "mean_raysweep": float(grey(reference, seen).mean()),
        "opacity": float(mean[seen][:, 3].mean()),
        "opacity_raysweep": float(reference[seen][:, 3].mean()),
    }


def main():
    setup_file, result_file = (Path(name).resolve() for name in sys.argv[sys.argv.index("--") + 1:])
    setup = json.loads(setup_file.read_text())
    scene = bpy.data.scenes.new("Cloud")
    load_cloud(setup, scene)
    add_lights(setup, scene)
    place_camera(setup, scene)
    set_up_rendering(setup, scene)
    result = measure(setup, scene, result_file.parent)
    result_file.write_text(json.dumps(result, indent=2) + "\n")


main()
