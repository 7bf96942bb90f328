"""One view of a cloud: Blender Cycles' time to 5 % of noise against the whole run of Raysweep to 1 % of error.

The same scene for both: extinction 20 per unit in a box of one unit, albedo 0.9, sun and sky. bench/quality/
cycles_render.py sets it up in Blender; that the mean of the pixels is the same proves that it is the same scene.
"""

import json
import math
import os
import shutil
import statistics
import subprocess
import time

EXTINCTION, ALBEDO, SUN, SKY, BOUNCES = 20, 0.9, (0.3, 0.5, -1, 3), 0.3, 64
SIZE, PIXELS = 128, 256
NOISE, ERROR = 0.05, 0.01
SWEEPS = (8, 16, 24, 32, 40, 48, 56, 64, 80, 96, 112, 128, 160, 192, 256, 384, 512)
REFERENCE_SWEEPS, REFERENCE_SEED = 4096, 1000


def raysweep_light(context, cloud, lit, sweeps, seed, threads):
    context.run("raysweep", "light", cloud, "-o", lit, "--extinction", EXTINCTION, "--albedo", ALBEDO, "--sun",
                ",".join(map(str, SUN)), "--sky", SKY, "--sweeps", sweeps, "--tolerance", 0, "--seed", seed,
                "--threads", threads, "--quiet", "--report", lit.with_suffix(".light.json"))


def raysweep_render(context, lit, threads):
    """@return the report, in which the camera is"""
    report = lit.with_suffix(".render.json")
    context.run("raysweep", "render", lit, "-o", lit.with_suffix(".exr"), "--size", f"{PIXELS},{PIXELS}", "--threads",
                threads, "--quiet", "--report", report)
    return json.loads(report.read_text())


def whole_run(context, cloud, sweeps, seed, threads):
    """Lights and renders with two commands, as a user would. @return seconds of both, and of their work alone"""
    lit = context.folder / "cycles_lit.vdb"
    start = time.perf_counter()
    raysweep_light(context, cloud, lit, sweeps, seed, threads)
    render = raysweep_render(context, lit, threads)
    wall = time.perf_counter() - start
    told = json.loads(lit.with_suffix(".light.json").read_text())
    return lit, {"wall": wall, "light": told["seconds"], "render": render["seconds"],
                 "all_sweeps": told["sweeps"] + told["sweeps_finishing"]}


def fewest_sweeps(context, cloud, reference, threads):
    """More and more sweeps until volume and picture, mean over seeds, are near enough to the reference."""
    tried = []
    for sweeps in SWEEPS:
        runs = []
        for seed in range(1, 3 if context.quick else 6):
            lit, run = whole_run(context, cloud, sweeps, seed, threads)
            for key, suffix in (("block_error", ".vdb"), ("picture_error", ".exr")):
                files = lit.with_suffix(suffix), reference.with_suffix(suffix)
                run[key] = float(context.run("raysweep_lit_error", *files))
            runs.append(run)
        middle = {key: statistics.median(run[key] for run in runs) for key in ("wall", "light", "render", "all_sweeps")}
        errors = {key: statistics.mean(run[key] for run in runs) for key in ("block_error", "picture_error")}
        tried.append({"sweeps": sweeps, **middle, **errors})
        if max(errors.values()) <= ERROR:
            return tried, True
    return tried, False


def run_blender(context, cloud, reference, camera, threads):
    setup, result = context.folder / "cycles_scene.json", context.folder / "cycles_blender.json"
    setup.write_text(json.dumps({
        "volume": str(cloud), "picture": str(reference.with_suffix(".exr")), "camera": camera, "extinction": EXTINCTION,
        "albedo": ALBEDO, "sun": SUN, "sky": SKY, "bounces": BOUNCES, "threads": threads,
        "samples": [4, 16] if context.quick else [16, 64, 128]}))
    script = context.root / "bench" / "quality" / "cycles_render.py"
    command = ["blender", "-b", "--factory-startup", "--python-exit-code", "3", "-P", str(script), "--", str(setup),
               str(result)]
    # Blender takes its modules from beside the first Python in PATH, which may be an environment's without numpy.
    path = os.pathsep.join((os.path.dirname(shutil.which("blender")), os.environ["PATH"]))
    with open(context.folder / "cycles_blender.log", "w", encoding="utf-8") as log:
        subprocess.run(command, stdout=log, stderr=subprocess.STDOUT, check=True, timeout=600,
                       env={**os.environ, "PATH": path})
    return json.loads(result.read_text())


def time_to_noise(runs):
    """From the number of samples whose noise is nearest: noise falls with the root of the samples, time grows with
    them."""
    nearest = min(runs, key=lambda run: abs(math.log(run["noise"] / NOISE)))
    samples = nearest["samples"] * (nearest["noise"] / NOISE) ** 2
    return {"samples": samples, "seconds": statistics.mean(nearest["seconds"]) * samples / nearest["samples"],
            "measured_samples": nearest["samples"], "measured_noise": nearest["noise"]}


def compare(context, threads):
    if shutil.which("blender") is None:
        print("skipped: blender is not here (scripts/setup.sh --tests installs it)")
        return {}
    cloud = context.cloud(SIZE, "--voxel-size", str(1 / SIZE))
    reference = context.folder / "cycles_reference.vdb"
    raysweep_light(context, cloud, reference, REFERENCE_SWEEPS, REFERENCE_SEED, threads)
    camera = raysweep_render(context, reference, threads)
    blender = run_blender(context, cloud, reference, camera, threads)
    tried, reached = fewest_sweeps(context, cloud, reference, threads)
    return {"blender": blender, "cycles": time_to_noise(blender["runs"]), "raysweep": tried, "reached": reached}
