"""Kinds of input that were once read, lit or reconstructed wrong without a word: makes a small one of each, runs the command on it and
compares with the exact answer. Needs python3-numpy, python3-openvdb, python3-h5py and oiiotool; prints the table of docs/validation.md.

kinds.py RAYSWEEP FOLDER [KIND...]"""

import json
import re
import struct
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pyopenvdb as vdb

RAYSWEEP, FOLDER = sys.argv[1], Path(sys.argv[2])
rows = []


def run(*words, fails=False):
    """What the command says. It must succeed, or with `fails` be refused."""
    done = subprocess.run([RAYSWEEP, *map(str, words)], cwd=FOLDER, capture_output=True, text=True)
    if done.returncode != (1 if fails else 0):
        sys.exit(f"exit {done.returncode}: {' '.join(map(str, words))}\n{done.stderr}")
    return done.stderr.replace("\n", " ")


def row(kind, right, found, holds):
    rows.append((kind, right, found, holds))
    print(f"| {kind} | {right} | {found} | {'yes' if holds else 'NO'} |", flush=True)


def write(name, values, grid_name="density", more=()):
    grid = vdb.FloatGrid()
    grid.copyFromArray(np.ascontiguousarray(values, dtype=np.float64))
    grid.name = grid_name
    vdb.write(str(FOLDER / name), [grid, *more])
    return grid


def read(name, shape, grid="density", start=(0, 0, 0)):
    values = np.zeros(shape)
    vdb.read(str(FOLDER / name), grid).copyToArray(values, ijk=start)
    return values


# --- Light.

def half_transparent_solids():
    """No source radiance is above albedo times the sky's, and at albedo 1 all is 1."""
    size, chance = 32, np.random.default_rng(7)
    worst, mean = 0, 0
    for noise in (0, .1, .3):
        opacity = np.zeros((size,) * 3)
        opacity[:, 10:20, :] = .3 + noise * chance.standard_normal((size, 10, size))
        write("plate.vdb", np.clip(opacity, 0, 1))
        run("light", "plate.vdb", "-o", "lit.vdb", "--ramp", "0,1", "--sky", 1, "--albedo", 1)
        lit = read("lit.vdb", (size + 2,) * 3, "radiosity", (-1,) * 3)
        worst, mean = max(worst, lit.max()), max(mean, abs(lit[lit > 0].mean() - 1))
    row("half-transparent, noisy solids in a furnace", "S ≤ 1.01, mean within 1 %", f"{worst:.3f}, {100 * mean:.2f} %",
        worst <= 1.01 and mean <= .01)


def fire_in_uneven_smoke():
    """Every pixel of an even fire shows its column, whatever the smoke."""
    size, chance = 24, np.random.default_rng(7)
    thin, uneven = np.ones((size,) * 3), 10 ** chance.uniform(-2, 0, (size,) * 3)
    thin[12, 12, 12] = 1e-6
    worst = 0
    for smoke in (thin, uneven):
        fire = vdb.FloatGrid()
        fire.copyFromArray(np.ones((size,) * 3))
        fire.name = "fire"
        write("smoke.vdb", 1e-5 * smoke, more=[fire])
        run("light", "smoke.vdb", "-o", "lit.vdb", "--albedo", 0, "--emission", "grid:fire")
        run("render", "lit.vdb", "-o", "fire.exr", "--size", "48,48", "--ortho", 16, "--up", "0,1,0", "--step", 0.1,
            "--eye", "11.5,11.5,100", "--target", "11.5,11.5,11.5")
        stats = subprocess.run(["oiiotool", str(FOLDER / "fire.exr"), "--cut", "16x16+16+16", "--printstats"], capture_output=True,
                               text=True, check=True).stdout
        exact = size / (4 * np.pi)
        for side in ("Min", "Max"):
            worst = max(worst, abs(float(re.search(side + r":\s+(\S+)", stats)[1]) / exact - 1))
    row("fire in smoke that is thin in places", "every pixel within 1 %", f"{100 * worst:.2f} %", worst <= .01)


# --- Files.

def tiff(pages_in_description=0, bits=8):
    """One directory of 6x5 pixels, and what ImageJ puts behind it."""
    width, height = 6, 5
    slices = max(1, pages_in_description)
    values = np.arange(slices * height * width, dtype=np.uint8).reshape(slices, height, width)
    packed = values.tobytes() if bits == 8 else np.packbits((values > 14).astype(np.uint8), axis=2).tobytes()
    text = f"ImageJ=1.53\nimages={slices}\nslices={slices}\n\0".encode() if pages_in_description else b"a mask\0"
    entries = [(256, 4, 1, width), (257, 4, 1, height), (258, 3, 1, bits), (259, 3, 1, 1), (262, 3, 1, 1), (270, 2, len(text), None),
               (273, 4, 1, None), (277, 3, 1, 1), (278, 4, 1, height), (279, 4, 1, len(packed) // slices)]
    at_text = 8 + 2 + 12 * len(entries) + 4
    places = {270: at_text, 273: at_text + len(text)}
    out = b"II*\0" + struct.pack("<IH", 8, len(entries))
    for tag, kind, count, value in entries:
        out += struct.pack("<HHII", tag, kind, count, places.get(tag, value))
    (FOLDER / "a.tif").write_bytes(out + struct.pack("<I", 0) + text + packed)
    run("import", "a.tif", "-o", "a.vdb")
    return values, read("a.vdb", (width, height, slices))


def stacks_of_image_j():
    values, found = tiff(pages_in_description=4)
    same = np.array_equal(np.sort(found.ravel()), np.sort(values.ravel()) / 1.0) or np.allclose(
        np.sort(found.ravel()), np.sort(values.ravel()) / 255)
    row("ImageJ stack in one directory", "4 slices of 6×5", f"{np.count_nonzero(found.sum((0, 1)))} slices, numbers {'same' if same else 'other'}", same)


def masks_of_one_bit():
    values, found = tiff(bits=1)
    ones = int((found == 1).sum())
    row("TIFF of one bit", "0 and 1, 15 of each", f"{ones} ones, {int((found == 0).sum())} zeros", ones == 15)


def nifti(slope, inter, rows_of_affine):
    values = np.arange(60, dtype="<i2")
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, 5, 4, 3, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 4, 16)
    struct.pack_into("<8f", header, 76, 1, 2, 3, 4, 1, 1, 1, 1)
    struct.pack_into("<3f", header, 108, 352, slope, inter)
    header[123] = 2  # millimetres
    struct.pack_into("<2h", header, 252, 0, 1)
    struct.pack_into("<12f", header, 280, *np.ravel(rows_of_affine))
    header[344:348] = b"n+1\0"
    (FOLDER / "a.nii").write_bytes(bytes(header) + values.tobytes())
    run("import", "a.nii", "-o", "a.vdb")


def slope_of_nothing():
    nifti(0, 5, [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]])
    found = read("a.vdb", (5, 4, 3))
    row("NIfTI with slope 0", "0 … 59", f"{found.min():g} … {found.max():g}", found.max() == 59)


def sheared_directions():
    nifti(1, 0, [[2, .5, 0, 1], [0, 3, 0, 2], [0, 0, 4, 3]])
    grid = vdb.readAllGridMetadata(str(FOLDER / "a.vdb"))[0]
    step = np.array(grid.transform.indexToWorld((0, 1, 0))) - grid.transform.indexToWorld((0, 0, 0))
    lean = abs(step[0]) / abs(step[1])
    row("NIfTI whose directions are sheared", "x leans by 0.5 / 3", f"{lean:.5f}", abs(lean - .5 / 3) < 1e-6)


# --- Scans: two balls, (centre, radius, density), by exact line integrals. World y points down the detector's rows of the file.

BALLS = (((0, 0, 0), 30, .02), ((14, 5, 4), 5, .03))
CLEAR, DENSE = (0, 8, 0), (14, 5, 4)


def integrals(origins, directions):
    directions = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    total = 0
    for centre, radius, density in BALLS:
        to = origins - np.array(centre)
        along = (to * directions).sum(-1)
        total = total + 2 * density * np.sqrt(np.maximum(along ** 2 - (to ** 2).sum(-1) + radius ** 2, 0))
    return total


def detector(angle, width, height, pixel, *, shift=0, source=None, plane=0, roll=0):
    """One view: the source or rays come from +x at 0, columns go along +y, rows along -z."""
    t, r = np.deg2rad(angle), np.deg2rad(roll)
    out = np.array([np.cos(t), np.sin(t), 0])
    u, v = np.array([-np.sin(t), np.cos(t), 0]), np.array([0, 0, -1.])
    u, v = np.cos(r) * u + np.sin(r) * v, np.cos(r) * v - np.sin(r) * u
    origin = -plane * out + u * (shift - (width - 1) / 2 * pixel) - v * (height - 1) / 2 * pixel
    view = dict(origin=origin, column=u * pixel, row=v * pixel)
    view.update(dict(source=source * out) if source else dict(direction=-out))
    return view


def project(views, width, height):
    place = np.indices((height, width))[..., None]
    for view in views:
        pixels = view["origin"] + place[1] * view["column"] + place[0] * view["row"]
        yield (integrals(view["source"], pixels - view["source"]) if "source" in view
               else integrals(pixels, view["direction"] + 0 * pixels))


def scan(views, width, height):
    """Writes p.mha and p.json."""
    values = np.stack(list(project(views, width, height))).astype("<f4")
    json.dump(dict(format="raysweep-geometry", version=1, beam="cone" if "source" in views[0] else "parallel",
                   detector=dict(width=width, height=height), views=[{k: list(map(float, x)) for k, x in view.items()} for view in views]),
              open(FOLDER / "p.json", "w"))
    head = f"ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = {width} {height} {len(values)}\n" \
           "ElementSpacing = 1 1 1\nElementType = MET_FLOAT\nElementDataFile = LOCAL\n"
    (FOLDER / "p.mha").write_bytes(head.encode() + values.tobytes())
    return values


def cone(width, height, **how):
    return [detector(angle, width, height, 1.5, source=300, plane=200, **how) for angle in range(0, 360, 3)]


def reconstruct(*options, size=(64, 64, 32), name="v.vdb"):
    said = run("ct", "-o", name, "--size", ",".join(map(str, size)), *options)
    return vdb.read(str(FOLDER / name), "density"), said


def mean_around(grid, point, reach=2):
    axis = np.arange(-reach, reach + 1)
    at = [np.round(grid.transform.worldToIndex(tuple(float(p + d) for p, d in zip(point, (i, j, k))))).astype(int)
          for i in axis for j in axis for k in axis]
    values = grid.getConstAccessor()
    return float(np.mean([values.getValue(tuple(int(x) for x in index)) for index in at]))


def judge(kind, grid, right=.03):
    errors = [mean_around(grid, CLEAR) / .02 - 1, mean_around(grid, DENSE) / .05 - 1]
    row(kind, f"0.02 and 0.05 within {100 * right:g} %", ", ".join(f"{100 * e:+.1f} %" for e in errors), abs(errors[0]) <= right)


def half_fan():
    scan(cone(72, 40, shift=36), 72, 40)
    for method in ("fdk", "sart"):
        judge("displaced detector, " + method, reconstruct("p.mha", "--geometry", "p.json", "--method", method, "--spacing", 1)[0])


def on_its_side():
    scan(cone(60, 112, roll=90), 60, 112)
    judge("detector on its side, fdk",
          reconstruct("p.mha", "--geometry", "p.json", "--method", "fdk", "--spacing", 1, size=(64, 64, 64))[0])


def rolled():
    seconds = []
    for roll in (0, 3, 90):
        width, height = (112, 80) if roll < 90 else (80, 112)
        scan(cone(width, height, roll=roll), width, height)
        run("ct", "p.mha", "-o", "v.vdb", "--geometry", "p.json", "--size", "64,64,64", "--spacing", 1, "--iterations", 2, "--report", "r.json")
        seconds.append(json.load(open(FOLDER / "r.json"))["seconds_per_update"])
    ratios = [s / seconds[0] for s in seconds[1:]]
    row("detector rolled by 3° and 90°, time of sart", "≤ 2 × upright", ", ".join(f"{r:.1f} ×" for r in ratios), max(ratios) <= 2.2)


def truncated():
    scan([detector(angle, 40, 40, 1) for angle in range(0, 180, 2)], 40, 40)
    for method in ("fbp", "sart"):
        grid, said = reconstruct("p.mha", "--geometry", "p.json", "--method", method, size=(40, 40, 40))
        judge(f"object wider than the detector, {method}{', warned' if 'beyond' in said or 'wider' in said else ''}", grid)


def spacing():
    scan([detector(angle, 80, 80, 1) for angle in range(0, 180, 2)], 80, 80)
    for method in ("fbp", "sart"):
        grid, _ = reconstruct("p.mha", "--geometry", "p.json", "--method", method, "--spacing", "1,1,2.5", size=(80, 80, 32))
        judge("voxels of 1×1×2.5, " + method, grid)


# --- HDF5.

def counts(name, *, unit=None, dark=True, kind="u2", wrap=False):
    angles = np.arange(0, 180, 2.)
    views = [detector(angle, 80, 40, 1) for angle in angles]
    values = np.stack(list(project(views, 80, 40)))
    data = np.round(40000 * np.exp(-values) + 100 * dark)
    with h5py.File(FOLDER / name, "w") as file:
        group = file.create_group("exchange")
        group["data"] = data.astype("u2").view("i2") if wrap else data.astype(kind)
        group["data_white"] = np.full((3, 40, 80), 40000 + 100 * dark, "u2")
        if dark:
            group["data_dark"] = np.full((3, 40, 80), 100, "u2")
        group["theta"] = np.deg2rad(angles) if unit else angles
        if unit:
            group["theta"].attrs["units"] = unit


def h5(kind, said_word, *options, **how):
    counts("p.h5", **how)
    grid, said = reconstruct("p.h5", "--axis-column", 39.5, "--method", "fbp", *options, size=(80, 80, 40))
    judge(kind + (", said" if said_word in said else ", NOT SAID: " + said), grid)


def scan_files():
    h5("angles in radians", "radian", unit="rad")
    h5("no dark fields", "without beam", dark=False)
    counts("p.h5", wrap=True)
    said = run("ct", "p.h5", "-o", "v.vdb", "--axis-column", 39.5, "--method", "fbp", "--size", "80,80,40", fails=True)
    row("unsigned counts in a signed type", "refused, with what to do", said.strip()[-60:], "--unsigned-counts" in said)
    h5("the same with --unsigned-counts", "", "--unsigned-counts", wrap=True)


def sinograms():
    angles = range(0, 180, 2)
    values = np.stack([v[0] for v in project([detector(a, 80, 1, 1) for a in angles], 80, 1)]).astype("<f4")
    head = f"ObjectType = Image\nNDims = 2\nBinaryData = True\nDimSize = 80 {len(values)}\nElementSpacing = 1 1\n" \
           "ElementType = MET_FLOAT\nElementDataFile = LOCAL\n"
    (FOLDER / "s.mha").write_bytes(head.encode() + values.tobytes())
    said = run("ct", "s.mha", "-o", "v.vdb", "--parallel", "--method", "fbp")
    middle = mean_around(vdb.read(str(FOLDER / "v.vdb"), "density"), (0, 8, 0), 0)
    row("a sinogram as a picture" + (", said" if "sinogram" in said else ""), "0.02 within 3 %", f"{100 * (middle / .02 - 1):+.1f} %",
        abs(middle / .02 - 1) <= .03)


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    kinds = (half_transparent_solids, fire_in_uneven_smoke, stacks_of_image_j, masks_of_one_bit, slope_of_nothing, sheared_directions,
             half_fan, on_its_side, rolled, truncated, spacing, scan_files, sinograms)
    print("| kind | right | found | holds |\n| --- | --- | --- | --- |")
    for kind in kinds:
        if len(sys.argv) < 4 or kind.__name__ in sys.argv[3:]:
            kind()
    sys.exit(not all(holds for *_, holds in rows))


main()
