"""Pictures, drawn by gnuplot."""

import csv
import os
import subprocess
import sys
from pathlib import Path

# Benchmark, and what it is called in the chart.
BARS = (("dense_nearest", "dense, 276×276×130"),
        ("smoke_nearest", "sparse smoke"),
        ("dense_colour", "dense, three wavelengths"),
        ("dense_surfaces", "dense, surfaces"),
        ("dense_linear", "dense, linear rays"))


def gnuplot(size, font, script, output):
    """Beside the target first: a picture appears whole or not at all. The kind of file follows from its name."""
    kind = "svg" if output.suffix == ".svg" else "pngcairo"
    script = f"set terminal {kind} size {size} background 'white' font '{font}'\n" + script
    temporary = output.with_name(f".{output.stem}.part{os.getpid()}{output.suffix}")
    try:
        subprocess.run(["gnuplot"], input=f"set output '{temporary}'\n{script}", text=True, check=True)
        os.replace(temporary, output)
    finally:
        temporary.unlink(missing_ok=True)
    return output


def details_of(path):
    with open(path, encoding="utf-8", newline="") as file:
        return {line["what"]: line for line in csv.DictReader(file) if line["kind"] == "detail"}


def draw(results, output):
    """Bars of the time of a sweep as a multiple of the time that memory takes for the same voxels."""
    details = details_of(results)
    bars = [(label, float(details[f"{name} x_stream"]["median"]), float(details[f"{name} ms"]["median"]))
            for name, label in BARS if f"{name} x_stream" in details]
    lines = [f'{len(bars) - i} {times:.3f} "{label}" "{times:.2f}×  ({ms:.1f} ms)"'
             for i, (label, times, ms) in enumerate(bars)]
    widest = max(times for _, times, _ in bars)
    data = "$bars << EOD\n" + "\n".join(lines) + "\nEOD\n"
    return gnuplot(f"860,{130 + 46 * len(bars)}", "Helvetica,15", data + f"""
set label 1 'Time of one sweep of all voxels, two cores' at screen 0.5,0.94 center font ',17'
set label 2 'as multiples of the time that memory takes to stream the voxels once (dashed)' \\
    at screen 0.5,{1 - 50 / (130 + 46 * len(bars)):.3f} center font ',13'
set tmargin 4
set xrange [0:{max(1.7 * widest, 1.3)}]
set yrange [0.4:{len(bars) + 0.6}]
set border 1
set xtics nomirror
set ytics nomirror scale 0
set grid xtics lc rgb '#dddddd'
set style fill solid 1 noborder
set arrow from 1,graph 0 to 1,graph 1 nohead dt 2 lw 2 lc rgb '#b03020' front
unset key
plot $bars using (0.5*$2):1:(0.5*$2):(0.34):ytic(3) with boxxyerror lc rgb '#3b6ea5', \\
     $bars using 2:1:4 with labels left offset 0.7,0
""", output)


def curves(points, axis):
    """One data block for each case and setting, and the names they belong to."""
    groups = {}
    for point in points:
        if float(point["tolerance"]) == 0:
            groups.setdefault(point["case"], {}).setdefault(point["setting"], []).append(point)
    blocks, plots = [], []
    for c, (case, settings) in enumerate(groups.items()):
        names = []
        for s, (setting, line) in enumerate(settings.items()):
            rows = "\n".join(f"{point[axis]} {100 * float(point['error'])}" for point in line)
            blocks.append(f"$curve{c}_{s} << EOD\n{rows}\nEOD")
            names.append(f"$curve{c}_{s} with lines lw 2 lc {s + 1} title '{setting}'")
        plots.append((case, names))
    return blocks, plots


def draw_convergence(points, folder):
    """Error against sweeps, and against seconds: one picture each with all cases."""
    pictures = []
    for axis, name, label in (("all", "sweeps", "sweeps, finishing ones included"), ("seconds", "seconds", "seconds")):
        blocks, plots = curves(points, axis)
        rows = (len(plots) + 1) // 2
        script = "\n".join(blocks) + f"""
set multiplot layout {rows},{min(2, len(plots))}
set logscale xy
set format xy '%g'
set grid
set key outside right top
set xlabel '{label}'
set ylabel 'block error, %'
"""
        for case, names in plots:
            light, thickness, albedo = case.split()
            script += f"set title '{light}, optical thickness {thickness}, albedo {albedo}'\n"
            script += "plot " + ", ".join(names) + ", 1 with lines dt 2 lc 'black' notitle\n"
        size = f"1100,{360 * rows + 40}"
        pictures.append(gnuplot(size, "Helvetica,12", script + "unset multiplot\n", folder / f"convergence_{name}.svg"))
    return pictures


if __name__ == "__main__":
    print(draw(Path(sys.argv[1]), Path(sys.argv[2])))
