"""Tables and charts of cube4_figures.sh, from the reports that it left in WORK: cube4_tables.py WORK OUT"""

import json
import math
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "harness"))
from chart import gnuplot  # noqa: E402

from cube4_phantom import CONTRASTS, contrasts  # noqa: E402

ROUNDINGS = ("truncate", "nearest", "stochastic")
COLORS = {"truncate": "#b03020", "nearest": "#3b6ea5", "stochastic": "#2e8b57"}
CLOCK = 100e6  # Hz
PASSES = 1000  # of the paper's runs


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


def table(title, head, rows):
    print(f"\n{title}\n")
    print("| " + " | ".join(head) + " |")
    print("| " + " | ".join("---" for _ in head) + " |")
    for row in rows:
        print("| " + " | ".join(str(value) for value in row) + " |")


def power(value):
    """Two digits: 3.1e-4"""
    if value == 0 or not math.isfinite(value):
        return f"{value:g}"
    exponent = math.floor(math.log10(abs(value)))
    digits = f"{value / 10 ** exponent:.1f}"
    if digits.lstrip("-") == "10.0":
        digits, exponent = digits.replace("10.0", "1.0"), exponent + 1
    return f"{digits}e{exponent}"


def block(name, points):
    return f"${name} << EOD\n" + "\n".join(" ".join(str(value) for value in point) for point in points) + "\nEOD\n"


# Scaling.

class Use:
    """Of one machine in one kind of pass."""

    def __init__(self, counts):
        self.counts = counts
        self.pipelines, self.passes, self.cycles = counts["pipelines"], counts["passes"], counts["cycles"]
        self.voxels = counts["cycles"] / counts["cycles_per_voxel"] / counts["passes"]
        self.per_voxel = counts["cycles_per_voxel"]
        self.per_pipeline = self.per_voxel * self.pipelines
        self.words = counts["neighbour_words"] / (self.passes * self.voxels)
        self.stalls = counts["stalls"] / counts["cycles"]


def uses(work):
    """{(what, size, pipelines, shared port): Use}"""
    found = {}
    for path in work.glob("count-*.json"):
        kind, size, pipelines, shared = re.fullmatch(r"count-(\w+)-(\d+)-(\d+)(-shared)?", path.stem).groups()
        report = read(path)
        if report["bank_conflicts"]:
            raise SystemExit(f"{path}: {report['bank_conflicts']} conflicts")
        parts = {"illuminate": report} if kind == "illuminate" else {
            "project": report["project"], "backproject": report["backproject"]}
        for what, counts in parts.items():
            found[what, int(size), int(pipelines), bool(shared)] = Use(counts)
    return found


def scaling(work, out):
    found = uses(work)
    sizes = sorted({key[1] for key in found})
    rows = []
    for size in sizes:
        for pipelines in sorted({key[2] for key in found if key[1] == size}):
            light, forth, back = (found[what, size, pipelines, False] for what in ("illuminate", "project", "backproject"))
            shared = [found.get((what, size, pipelines, True)) for what in ("illuminate", "backproject")]
            rows.append((size, pipelines, f"{light.per_pipeline:.3f}", f"{forth.per_pipeline:.3f}",
                         f"{back.per_pipeline:.3f}", " / ".join(f"{use.per_pipeline:.3f}" if use else "–" for use in shared),
                         " / ".join(f"{100 * use.stalls:.1f}" for use in (light, forth, back)),
                         " / ".join(f"{use.words:.2f}" for use in (light, forth, back)),
                         f"{light.counts['bytes_per_module']} / {back.counts['bytes_per_module']}",
                         f"{light.counts['buffer_bytes_per_pipeline']} / {back.counts['buffer_bytes_per_pipeline']}"))
    table("Cycles per voxel and pipeline, floats. L: illuminating, P: projecting, B: backprojecting",
          ("N", "p", "L", "P", "B", "one port: L / B", "stalls, % of cycles: L / P / B", "neighbour words a voxel: L / P / B",
           "bytes a module: L / SART", "buffer bytes a pipeline: L / SART"), rows)

    def points_of(what, size, shared=False):
        return sorted((use.pipelines, use.per_voxel, use.per_pipeline) for key, use in found.items()
                      if key[0] == what and key[1] == size and key[3] == shared)

    shown = sizes[-2]  # all pipelines, and with a shared port
    curves = (("project", False, "projecting", "#2e8b57", 9), ("illuminate", False, "illuminating", "#3b6ea5", 7),
              ("backproject", False, "backprojecting", "#d08020", 6), ("illuminate", True, "illuminating, one port", "#b03020", 5))
    script, left, right = "", [], []
    for number, (what, shared, title, color, point) in enumerate(curves):
        script += block(f"rate{number}", points_of(what, shown, shared))
        size = 1.3 if point == 6 else 0.8
        left.append(f"$rate{number} using 1:2 with linespoints pt {point} ps {size} lw 2 lc rgb '{color}' title '{title}'")
    colors = ("#b03020", "#d08020", "#2e8b57", "#3b6ea5")
    for number, size in enumerate(sizes[-len(colors):]):
        script += block(f"size{number}", points_of("illuminate", size))
        right.append(f"$size{number} using 1:3 with linespoints pt {number + 4} ps 0.8 lw 2 lc rgb '{colors[number]}' "
                     f"title 'N = {size}'")
    gnuplot("1000,420", "Helvetica,13", script + f"""
set multiplot layout 1,2
set logscale x 2
set grid
set xlabel 'pipelines p'
set xrange [0.9:72]
set logscale y
set mytics 1
set format y '%g'
set title 'cycles per voxel, N = {shown}'
set key right top
plot {", ".join(left)}
unset logscale y
set title 'illuminating: cycles per voxel, times p'
set yrange [1.8:*]
set key left top
plot {", ".join(right)}
unset multiplot
""", out / "cube4_scaling.svg")


def papers_runs(work):
    rows = []
    pipelines = sorted({int(path.stem.split("-")[2]) for path in work.glob("paper-*.json")})
    for p in pipelines:
        row = [p]
        for what in ("illuminate", "reconstruct"):
            report = read(work / f"paper-{what}-{p}.json")
            parts = [report["project"], report["backproject"]] if what == "reconstruct" else [report]
            cycles = sum(part["cycles"] / part["passes"] for part in parts)
            voxels = Use(parts[0]).voxels
            row += [f"{voxels / 1e6:.2f} M", f"{cycles / voxels * p:.3f}", f"{PASSES * cycles / CLOCK:.1f} s"]
        rows.append(row)
    table(f"{PASSES} sweeps of the engine room, {PASSES} updates of the engine, at {CLOCK / 1e6:g} MHz",
          ("p", "room, voxels", "cycles per voxel and pipeline", "1000 sweeps", "engine, voxels", "cycles per voxel and pipeline",
           "1000 updates"), rows)


# Precision.

def of_formats(work, record, pattern):
    """{(bits, rounding): report path} of the formats in which `pattern` has the bits."""
    found = {}
    for path in work.glob(f"{record}-*.json"):
        match = re.fullmatch(re.escape(record) + "-" + pattern.replace("BITS", r"(\d+)") + r"-(\w+)", path.stem)
        if match:
            found[int(match[1]), match[2]] = path
    return found


def bits_of(paths):
    return sorted({bits for bits, _ in paths})


def records(work, kind):
    names = {match[1] for path in work.glob(f"{kind}-*.json") if (match := re.fullmatch(rf"{kind}-([\d.]+)", path.stem))}
    return sorted(names, key=float)


def rms(path):
    return read(path)["rms_against_float"]


def triple(paths, bits, value):
    return " / ".join(value(paths[bits, rounding]) for rounding in ROUNDINGS)


def panels(titles, curves, plotted, more, output):
    """One panel a title; `curves`: of each, {rounding: points}; `plotted`: by which columns and how."""
    script, blocks = "", ""
    for number, title in enumerate(titles):
        plots = []
        for rounding, points in curves[number].items():
            blocks += block(f"c{number}_{rounding}", points)
            plots.append(f"$c{number}_{rounding} using 1:2 with linespoints pt 7 ps 0.6 lw 2 lc rgb '{COLORS[rounding]}' "
                         f"title '{rounding}'")
        key = "set key" if number + 1 == len(titles) else "unset key"
        script += f"{key}\nset title '{title}'\nplot {', '.join(plots + plotted(number))}\n"
    columns = min(len(titles), 2 if len(titles) == 4 else 3)
    lines = math.ceil(len(titles) / columns)
    gnuplot(f"{340 * columns + 20 if columns == 3 else 1000},{360 * lines}", "Helvetica,13",
            blocks + f"set multiplot layout {lines},{columns}\nset grid\n" + more + script + "unset multiplot\n", output)


LOG = "set logscale y\nset mytics 1\nset format y '10^{%L}'\nset key right top\nset xtics 4\n"


def light(work, out):
    zetas = records(work, "light")
    formats = {zeta: of_formats(work, f"light-{zeta}", "16,BITS,16,16,48") for zeta in zetas}
    head = ("bits of energy", *(f"ζ {zeta}" for zeta in zetas))
    bits = bits_of(formats[zetas[0]])
    order = " / ".join(ROUNDINGS)
    table(f"Illumination: RMS of deposits to floats; {order}", head,
          [(b, *(triple(formats[zeta], b, lambda path: power(rms(path))) for zeta in zetas)) for b in bits])
    table(f"Power that rounding destroyed (+) or made (-), part of all; {order}", head,
          [(b, *(triple(formats[zeta], b, lambda path: power(read(path)["balance"])) for zeta in zetas)) for b in bits])
    sweeps = ", ".join(f"ζ {zeta}: {read(next(iter(formats[zeta].values())))['sweeps']}" for zeta in zetas)
    print(f"\nSweeps with those that finish: {sweeps}")
    others = {"part (nearest rays)": of_formats(work, "parts", "16,24,BITS,16,48"),
              "weight (linear rays)": of_formats(work, "weights", "16,24,16,BITS,48")}
    table(f"Illumination, ζ 0.1, energies of 24 bits: RMS of deposits to floats, and power destroyed; {order}",
          ("bits", *(f"{name}: {what}" for name in others for what in ("RMS", "power"))),
          [(b, *(triple(paths, b, value) for paths in others.values()
                 for value in (lambda path: power(rms(path)), lambda path: power(read(path)["balance"])))) for b in bits])
    panels([f"ζ = {zeta}" for zeta in zetas],
           [{rounding: [(b, rms(formats[zeta][b, rounding])) for b in bits] for rounding in ROUNDINGS} for zeta in zetas],
           lambda number: [], LOG + "set xlabel 'bits of energy'\nset ylabel 'RMS of deposits to floats'\nset yrange [1e-6:2]\n",
           out / "cube4_light.svg")


def sart(work, out):
    relaxations = records(work, "sart")
    formats = {value: of_formats(work, f"sart-{value}", "BITS,24,24,24,48") for value in relaxations}
    updates = {value: read(work / f"sart-{value}-float-nearest.json")["updates"] for value in relaxations}
    head = ("bits of a voxel", *(f"λ {value}, {updates[value]} updates" for value in relaxations))
    bits = bits_of(formats[relaxations[0]])
    order = " / ".join(ROUNDINGS)
    table(f"SART: RMS to floats; {order}", head,
          [(b, *(triple(formats[value], b, lambda path: power(rms(path))) for value in relaxations)) for b in bits])
    panels([f"λ = {value}, {updates[value]} updates" for value in relaxations],
           [{r: [(b, rms(formats[value][b, r])) for b in bits] for r in ROUNDINGS} for value in relaxations],
           lambda number: [], LOG + "set xlabel 'bits of a voxel'\nset ylabel 'RMS to floats'\nset yrange [5e-7:2]\n",
           out / "cube4_sart.svg")
    if "0.2" in formats:
        others = [of_formats(work, "sart-0.2", pattern) for pattern in ("24,BITS,24,24,48", "24,24,24,BITS,48")]
        table(f"SART, λ 0.2, voxels of 24 bits: RMS to floats; {order}", ("bits", "of corrections", "of weights"),
              [(b, *(triple(paths, b, lambda path: power(rms(path))) for paths in others)) for b in bits_of(others[0])])
    inserts(work, out, formats, bits, updates)


def survives(found, exact):
    """The least contrast down to which all inserts are read to half of what they are, as far as rounding is to blame."""
    least = None
    for contrast, value, reference in zip(CONTRASTS, found, exact):
        if abs(value - reference) > contrast / 2:
            break
        least = contrast
    return f"{100 * least:.2g}" if least else f"> {100 * CONTRASTS[0]:g}"


def inserts(work, out, formats, bits, updates):
    order = " / ".join(ROUNDINGS)
    values = list(formats)
    exact = {value: contrasts(work / f"sart-{value}-float-nearest.mha") for value in values}
    seen = {(value, *key): contrasts(path.with_suffix(".mha")) for value in values for key, path in formats[value].items()}
    one = CONTRASTS.index(0.01)
    head = ("bits of a voxel", *(f"λ {value}" for value in values))
    rows = [(b, *(" / ".join(f"{100 * seen[value, b, r][one]:.2f}" for r in ROUNDINGS) for value in values)) for b in bits]
    rows.append(("float", *(f"{100 * exact[value][one]:.2f}" for value in values)))
    table(f"An insert of 1 %, as it is read, %; {order}", head, rows)
    table(f"The least contrast that is read within half of itself of what floats read, %; {order}", head,
          [(b, *(" / ".join(survives(seen[value, b, r], exact[value]) for r in ROUNDINGS) for value in values)) for b in bits])
    table("All inserts as floats read them, %", ("insert, %", *(f"λ {value}" for value in values)),
          [(f"{100 * contrast:g}", *(f"{100 * exact[value][i]:.3f}" for value in values)) for i, contrast in enumerate(CONTRASTS)])
    curves = [{r: [(b, 100 * seen[value, b, r][one]) for b in bits] for r in ROUNDINGS} for value in values]
    panels([f"λ = {value}, {updates[value]} updates" for value in values], curves,
           lambda number: [f"{100 * exact[values[number]][one]} with lines dt 2 lw 2 lc 'black' title 'float'"],
           "set xlabel 'bits of a voxel'\nset ylabel 'insert of 1 %, as read, %'\nset key right bottom\nset xtics 4\n"
           "set yrange [-3:3]\n", out / "cube4_contrast.svg")


def main():
    work, out = (Path(argument) for argument in sys.argv[1:3])
    scaling(work, out)
    papers_runs(work)
    light(work, out)
    sart(work, out)


if __name__ == "__main__":
    main()
