"""A slice for cube4_figures.sh: a disc of density 1, a core of twice that, and around it inserts a little denser than the
disc. Writes scan.mha, its exact line integrals in 60 parallel views, scan.json, and from_above.json, rays along z through
the voxels: cube4_phantom.py FOLDER"""

import array
import json
import math
import sys
from pathlib import Path

SIZE = 64
VIEWS = 60
DISC, CORE, INSERT, RING = 26, 5, 4, 17  # radii; RING: of the circle that inserts are on
CONTRASTS = (0.08, 0.04, 0.02, 0.01, 0.005, 0.0025, 0.00125, 0.000625)
INSIDE, AROUND = 3.5, (5.5, 7.5)  # distances from an insert's middle at which voxels are read


def places():
    angles = (2 * math.pi * i / len(CONTRASTS) for i in range(len(CONTRASTS)))
    return [(RING * math.cos(angle), RING * math.sin(angle)) for angle in angles]


def line_integral(direction, offset):
    """Along a ray at distance `offset` from the middle, counted along `direction`."""
    discs = [(0, 0, DISC, 1), (0, 0, CORE, 1)]
    discs += [(x, y, INSERT, contrast) for (x, y), contrast in zip(places(), CONTRASTS)]
    total = 0.0
    for x, y, radius, density in discs:
        off = offset - (x * direction[0] + y * direction[1])
        if abs(off) < radius:
            total += density * 2 * math.sqrt(radius * radius - off * off)
    return total


def geometry(width, height, views):
    return json.dumps({"format": "raysweep-geometry", "version": 1, "beam": "parallel",
                       "detector": {"width": width, "height": height}, "views": views})


def write_scan(folder):
    middle = (SIZE - 1) / 2
    values, views = array.array("f"), []
    for number in range(VIEWS):
        angle = math.pi * number / VIEWS
        column = (-math.sin(angle), math.cos(angle), 0)
        direction = (-math.cos(angle), -math.sin(angle), 0)
        origin = [-SIZE * d - middle * c for d, c in zip(direction, column)]
        views.append({"direction": direction, "origin": origin, "column": column, "row": (0, 0, -1)})
        values.extend(line_integral(column, pixel - middle) for pixel in range(SIZE))
    if sys.byteorder == "big":
        values.byteswap()
    head = ("ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
            f"DimSize = {SIZE} 1 {VIEWS}\nElementSpacing = 1 1 1\nElementType = MET_FLOAT\nElementDataFile = LOCAL\n")
    (folder / "scan.mha").write_bytes(head.encode() + values.tobytes())
    (folder / "scan.json").write_text(geometry(SIZE, 1, views), encoding="utf-8")
    above = {"direction": [0, 0, -1], "origin": [-middle, -middle, SIZE], "column": [1, 0, 0], "row": [0, 1, 0]}
    (folder / "from_above.json").write_text(geometry(SIZE, SIZE, [above]), encoding="utf-8")


def read_slice(path):
    data = path.read_bytes()
    values = array.array("f")
    values.frombytes(data[data.index(b"LOCAL\n") + len(b"LOCAL\n"):])
    if sys.byteorder == "big":
        values.byteswap()
    if len(values) != SIZE * SIZE:
        raise SystemExit(f"{path}: {len(values)} voxels, not {SIZE * SIZE}")
    return values


def contrasts(path):
    """Of each insert, as a slice shows it: mean inside over mean around, less 1."""
    values, found = read_slice(path), []
    for x, y in places():
        sums = {True: [], False: []}
        for row in range(SIZE):
            for column in range(SIZE):
                distance = math.hypot(column - (SIZE - 1) / 2 - x, row - (SIZE - 1) / 2 - y)
                if distance < INSIDE or AROUND[0] <= distance < AROUND[1]:
                    sums[distance < INSIDE].append(values[row * SIZE + column])
        inside, around = (sum(part) / len(part) for part in (sums[True], sums[False]))
        found.append(inside / around - 1 if around else -1.0)
    return found


if __name__ == "__main__":
    write_scan(Path(sys.argv[1]))
