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


def gnuplot(script, output):
    """Beside the target first: a picture appears whole or not at all."""
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
    return gnuplot(data + f"""
set terminal svg size 860,{150 + 46 * len(bars)} background 'white' font 'Helvetica,15'
set title 'One sweep of all voxels, two cores: time ÷ time to stream the voxels through memory' font ',16'
set xrange [0:{max(1.25 * widest, 1.3)}]
set yrange [0.4:{len(bars) + 0.6}]
set border 1
set xtics nomirror
set ytics nomirror scale 0
set grid xtics lc rgb '#dddddd'
set style fill solid 1 noborder
set arrow from 1,graph 0 to 1,graph 1 nohead dt 2 lw 2 lc rgb '#b03020' front
set xlabel 'dashed: reading extinction, unshot and deposited power once and writing the latter two, 20 bytes a voxel, at the measured bandwidth' font ',12'
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
set terminal svg size 1100,{360 * rows + 40} background 'white' font 'Helvetica,12'
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
        pictures.append(gnuplot(script + "unset multiplot\n", folder / f"convergence_{name}.svg"))
    return pictures


if __name__ == "__main__":
    print(draw(Path(sys.argv[1]), Path(sys.argv[2])))
