"""Tables and charts of photo_figures.sh, from the reports that it left in WORK: photo_tables.py WORK OUT [--marks N,N,...]"""

import argparse
import csv
import json
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "harness"))
from chart import gnuplot  # noqa: E402

METHODS = ("paper", "consistent")
SHARES = ("0", "0.25", "0.5", "0.75", "1")
SCENES = ("triangles", "few")
ORBITS = ("ring", "sphere")


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


def history(report):
    """(updates, seconds, RMS of opacity, RMS of opacity times colour)"""
    return list(zip(report["updates_history"], report["seconds_history"], report["rms_opacity_history"],
                    report["rms_color_history"]))


def at(points, updates):
    return next(point for point in points if point[0] == updates)


def write_table(path, head, rows):
    with open(path, "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(head)
        table.writerows(rows)


def block(name, points):
    return f"${name} << EOD\n" + "\n".join(" ".join(str(value) for value in point) for point in points) + "\nEOD\n"


def figure4(work):
    print("Figure 4, RMS over all voxels of an empty volume: of opacity, of opacity times colour")
    for name, title in (("triangles", "soft"), ("binary", "binary")):
        report = read(work / f"{name}.json")
        print(f"  {title:10} {report['rms_opacity']:.4f}  {report['rms_color']:.4f}")


def reaches(points, rms):
    """The first point whose opacity is no worse; nothing if there is none."""
    return next((point for point in points if point[2] <= rms), None)


def figure11(work, out, marks):
    empty = read(work / "triangles.json")
    start = (0, 0.0, empty["rms_opacity"], empty["rms_color"])
    runs = {method: [start] + history(read(work / f"{method}.json")) for method in METHODS}
    runs = {method: [point for point in points if point[0] <= marks[-1]] for method, points in runs.items()}
    write_table(out / "figure11.csv", ("method", "updates", "seconds", "rms_opacity", "rms_color"),
                [(method, *point) for method, points in runs.items() for point in points])
    print("Figure 11, RMS over all voxels after updates: " + ", ".join(str(mark) for mark in marks))
    script, curves = "", []
    for number, (method, points) in enumerate(runs.items()):
        script += block(method, points)
        for column, dashes, what in ((3, 1, "opacity"), (4, 2, "opacity × colour")):
            values = "  ".join(f"{at(points, mark)[column - 1]:.4f}" for mark in marks)
            print(f"  {method:11}{what:17} {values}")
            curves.append(f"${method} using 1:{column} with lines lw 2 dt {dashes} lc {number + 1} title '{method}, {what}'")
    last = {method: points[-1] for method, points in runs.items()}
    met = reaches(runs["consistent"], last["paper"][2])
    print(f"  paper: {last['paper'][1]:.2f} s for all updates, consistent {last['consistent'][1]:.2f} s")
    if met:
        print(f"  consistent has the paper's last opacity after {met[0]} updates, {met[1]:.3f} s, "
              f"{met[1] / last['paper'][1]:.4f} of the time; it ends at {last['consistent'][2] / last['paper'][2]:.3f} of it")
    gnuplot("1000,450", "Helvetica,13", script + "set xlabel 'updates'\nset ylabel 'RMS over all voxels'\nset grid\n"
            "set yrange [0:*]\nset key outside right center vertical\nplot " + ", ".join(curves) + "\n",
            out / "figure11.svg")


def figure12(work, out, marks):
    mark = marks[-2]
    points = {method: [(float(share), *at(history(read(work / f"share-{method}-{share}.json")), mark)[2:])
                       for share in SHARES] for method in METHODS}
    write_table(out / "figure12.csv", ("method", "updates", "diffuse", "rms_opacity", "rms_color"),
                [(method, mark, *point) for method in METHODS for point in points[method]])
    print(f"Figure 12, RMS after {mark} updates in known light of diffuse share " + ", ".join(SHARES))
    script, curves = "", []
    for number, method in enumerate(METHODS):
        script += block(method, points[method])
        for column, dashes, what in ((2, 1, "opacity"), (3, 2, "opacity × colour")):
            print(f"  {method:11}{what:17} " + "  ".join(f"{point[column - 1]:.4f}" for point in points[method]))
            curves.append(f"${method} using 1:{column} with linespoints pt 7 ps 0.5 lw 2 dt {dashes} lc {number + 1} "
                          f"title '{method}, {what}'")
    gnuplot("1000,450", "Helvetica,13", script + "set xlabel 'diffuse share of the light'\nset ylabel 'RMS over all voxels'\n"
            "set grid\nset yrange [0:*]\nset xrange [-0.05:1.05]\nset key outside right center vertical\nplot "
            + ", ".join(curves) + "\n", out / "figure12.svg")


def true_light(rig, transforms):
    """In the world, for the first view: rig.json has it along right, down and forward; a pose's columns are right, up, back."""
    pose = transforms["frames"][0]["transform_matrix"]
    right, down, forward = rig["light"]
    return [right * row[0] - down * row[1] - forward * row[2] for row in pose[:3]]


def degrees(a, b):
    lengths = math.hypot(*a) * math.hypot(*b)
    return math.degrees(math.acos(max(-1.0, min(1.0, sum(x * y for x, y in zip(a, b)) / lengths))))


def lights(work, out):
    rows = []
    for scene in SCENES:
        for orbit in ORBITS:
            for share in SHARES[1:]:
                name = f"light-{scene}-{orbit}-{share}"
                report = read(work / f"{name}.json")
                found = report["light"]
                truth = true_light(read(work / f"{name}-rig.json"), read(work / f"{name}-transforms.json"))
                rows.append((scene, orbit, share, round(degrees(found["direction"], truth), 2), round(found["diffuse"], 3),
                             round(found["confidence"], 3), round(report["timings"]["light"], 2)))
    head = ("scene", "orbit", "diffuse", "degrees_off", "diffuse_found", "confidence", "seconds")
    write_table(out / "light.csv", head, rows)
    print("--light auto: " + ", ".join(head))
    for row in rows:
        print("  " + "  ".join(f"{value!s:10}" for value in row))


def held_out(work):
    report = read(work / "held_out.json")
    print(f"Held out, {report['views_held_out']} views: {report['psnr_held_out']:.1f} dB, SSIM {report['ssim_held_out']:.3f}; "
          f"used, {report['views']}: {report['psnr_train']:.1f} dB; {report['seconds']:.1f} s")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("work", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--marks", default="10,100,300,1000", help="updates that tables tell of")
    arguments = parser.parse_args()
    marks = [int(mark) for mark in arguments.marks.split(",")]
    figure4(arguments.work)
    figure11(arguments.work, arguments.out, marks)
    figure12(arguments.work, arguments.out, marks)
    lights(arguments.work, arguments.out)
    held_out(arguments.work)


if __name__ == "__main__":
    main()
