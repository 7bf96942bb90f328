"""The parts of a run. Each measures something and returns it as plain data."""

import json
import os
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

import chart
import cycles

THREADS = 2


@dataclass
class Context:
    root: Path
    folder: Path  # of this run's raw results
    quick: bool

    @property
    def cache(self):
        """What is the same for every commit: references and large volumes."""
        folder = self.root / "build" / "bench" / "cache"
        folder.mkdir(parents=True, exist_ok=True)
        return folder

    def program(self, name):
        return str(self.root / "build" / "bin" / name)

    def run(self, name, *arguments, **options):
        """Runs a built program. @return what it prints"""
        command = [self.program(name), *map(str, arguments)]
        return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, **options).stdout

    def cloud(self, size, *arguments):
        path = self.cache / f"cloud{size}{''.join(arguments).replace('-', '_')}.vdb"
        if not path.exists():
            self.run("raysweep", "generate", "cloud", "-o", path, "--size", size, "--seed", 7, *arguments)
        return path


def csv_rows(text):
    head, *lines = [line.split(",") for line in text.splitlines()]
    return [dict(zip(head, line)) for line in lines]


SWEEPS = ("dense_nearest", "dense_linear", "dense_surfaces", "dense_colour", "smoke_nearest", "smoke_nearest_1thread",
          "smoke_in_large_box")


CT = ("ct_parallel", "ct_cone", "ct_half", "ct_half_cone", "ct_rolled", "ct_rolled_more", "ct_on_side",
      "ct_fdk")


CUBE4 = ("cube4_64", "cube4_64_one", "cube4_64_fixed", "cube4_128")
PHOTO = ("photo_consistent", "photo_consistent_1thread", "photo_paper", "photo_fit_1thread")


COUNTERS = ("ms", "ns_voxel", "ns_sample", "bytes_voxel", "x_stream", "GB_s_triad")


def counters(context, names, repetitions):
    """The counters of benchmarks of bench/runtime by name, for each of several runs of all of them."""
    runs = []
    for _ in range(1 if context.quick else repetitions):
        pattern = f"/({'|'.join(names)})(/|$)"
        text = context.run("raysweep_bench", f"--benchmark_filter={pattern}", "--benchmark_format=json",
                           stderr=subprocess.DEVNULL)
        benchmarks = [b for b in json.loads(text)["benchmarks"] if not b.get("error_occurred")]
        runs.append({b["name"].split("/")[1]: {key: b[key] for key in COUNTERS if key in b} for b in benchmarks})
    return runs


def sweep(context):
    """Time of a sweep."""
    return counters(context, SWEEPS, 7)


def ct(context):
    """Time of a SART update, and of what filtered backprojection does with a view."""
    return counters(context, CT, 5)


def photo(context):
    """Time of a correction by a photograph, and of the samples of a fit's rays."""
    return counters(context, PHOTO, 5)


def cube4(context):
    """Time of a sweep of the Cube-4 emulator."""
    return counters(context, CUBE4, 5)


def convergence(context):
    """Error against sweeps and time, for several settings of the solver."""
    summary = context.folder / "convergence_summary.csv"
    arguments = ["--cache", context.cache, "--summary", summary]
    if context.quick:
        arguments += ["--case", "sun 4 0.9", "--setting", "default", "--seeds", "2"]
    text = context.run("raysweep_convergence", *arguments)
    (context.folder / "convergence.csv").write_text(text)
    points = csv_rows(text)
    for picture in chart.draw_convergence(points, context.folder):
        print(f"picture: {picture.relative_to(context.root)}")
    return {"points": points, "summary": csv_rows(summary.read_text())}


def large(context):
    """Seconds and bytes per active voxel of ever larger clouds. In rounds: other work on the machine that lasts for a
    while then slows down large and small ones alike."""
    # Small volumes take many sweeps for as long a measurement.
    sweeps = {128: 512, 256: 128} if context.quick else {128: 1024, 256: 256, 512: 96, 1024: 32}
    rounds = []
    for _ in range(1 if context.quick else 3):
        found = [csv_rows(context.run("raysweep_large", context.cloud(size), "--sweeps", count, timeout=300))[0]
                 for size, count in sweeps.items()]
        rounds.append({volume["edge"]: {key: float(value) for key, value in volume.items()} for volume in found})
    return rounds


def light(context):
    """What `raysweep light` spends its time on, from its reports, and the time of the whole command."""
    data = Path(os.environ.get("RAYSWEEP_DATA") or context.root.parent / "shared" / "data")
    smoke = data / "vdb" / "smoke.vdb"
    if not smoke.exists():
        print(f"skipped: {smoke} is not here")
        return []
    report, lit = context.folder / "light_report.json", context.folder / "light.vdb"
    runs = []
    for _ in range(2 if context.quick else 9):
        start = time.perf_counter()
        context.run("raysweep", "light", smoke, "-o", lit, "--extinction", 0.1, "--albedo", 0.9, "--sun", "0.3,-1,0.2,3",
                    "--sky", 0.3, "--threads", THREADS, "--report", report, "--quiet")
        wall = time.perf_counter() - start
        told = json.loads(report.read_text())
        runs.append({"wall": wall, "seconds": told["seconds"], "all_sweeps": told["sweeps"] + told["sweeps_finishing"],
                     "bytes_per_voxel": told["peak_bytes"] / told["voxels_active"], **told["timings"]})
    lit.unlink()
    return runs


def cycles_part(context):
    return cycles.compare(context, THREADS)


PARTS = {"sweep": sweep, "convergence": convergence, "cycles": cycles_part, "large": large, "light": light,
         "ct": ct, "photo": photo, "cube4": cube4}
