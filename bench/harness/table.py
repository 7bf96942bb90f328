"""The table of what was asked and what was reached, from the raw results."""

import csv
import io
import statistics
from dataclasses import dataclass

MISSING = "not measured"


@dataclass
class Row:
    what: str
    asked: str
    aimed: str
    values: list  # one per repetition; empty: not measured
    limit: float  # what was asked, as a number
    at_least: bool = False  # else at most
    form: str = "{:.2f}"
    note: str = ""

    @property
    def value(self):
        return statistics.median(self.values) if self.values else None

    @property
    def met(self):
        return None if self.value is None else (self.value >= self.limit) == self.at_least or self.value == self.limit

    @property
    def reached(self):
        if self.value is None:
            return self.note or MISSING
        text = self.form.format(self.value)
        low, high = (self.form.format(pick(self.values)) for pick in (min, max))
        if low != high:
            text += f" ({low}–{high})"
        return text + (f"; {self.note}" if self.note else "") + ("" if self.met else " — missed")


def counters(runs, name, counter):
    return [run[name][counter] for run in runs if counter in run.get(name, ())]


def ratios(runs, counter, above, below):
    """Of two figures of one run: what else the machine does in another run does not come in."""
    return [run[above][counter] / run[below][counter] for run in runs if above in run and below in run]


def sweep_rows(runs):
    dense, smoke = "dense_nearest", "smoke_nearest"
    return [
        Row("sweep, dense 276×276×130, grey, nearest, per direction ÷ streaming 20 B/voxel at the triad bandwidth", "≤ 1.0",
            "≤ 0.5 with batches", counters(runs, dense, "x_stream"), 1),
        Row("the same, linear", "≤ 2.0", "≤ 1.0", counters(runs, "dense_linear", "x_stream"), 2),
        Row("the same, surfaces and gradients", "≤ 1.5", "≤ 0.8", counters(runs, "dense_surfaces", "x_stream"), 1.5),
        Row("smoke.vdb (sparse), per active voxel, ÷ the dense figure", "≤ 1.5", "≤ 1.15",
            ratios(runs, "ns_voxel", smoke, dense), 1.5),
        Row("three wavelengths ÷ one", "≤ 2.5", "≤ 2.0", ratios(runs, "ms", "dense_colour", dense), 2.5),
        Row("2 threads ÷ 1 thread, smoke", "≥ 1.8×", "≥ 1.95×", ratios(runs, "ms", smoke + "_1thread", smoke), 1.8,
            at_least=True, form="{:.2f}×"),
    ]


def convergence_row(convergence):
    row = Row("sweeps to 1 % block error, cube τ 4 ϖ 0.9 (32³)", "≤ 120", "≤ 60", [], 120, form="{:.0f}")
    # Both lights are asked for: the slower one counts.
    lines = [line for line in convergence.get("summary", ()) if line["case"].endswith(" 4 0.9")
             and line["setting"] == "default"]
    missed = [line for line in lines if not line["all"]]
    if missed:
        worst = max(missed, key=lambda line: float(line["least_error"]))
        row.note = f"not reached: {worst['case'].split()[0]}, {100 * float(worst['least_error']):.2f} % at best — missed"
    elif lines:
        slowest = max(lines, key=lambda line: float(line["all"]))
        row.values = [float(slowest["all"])]
        row.note = f"{slowest['case'].split()[0]}: {slowest['sweeps']} and {slowest['finishing']} to finish"
    return row


def cycles_row(cycles):
    row = Row("whole run to 1 % against Blender Cycles' time to 5 % noise of one 256² view of the same cloud (128³, σ 20, "
              "ϖ 0.9, sun + sky, 64 bounces)", "≥ 30× faster", "≥ 100×", [], 30, at_least=True, form="{:.0f}×")
    if cycles and not cycles["reached"]:
        row.note = "1 % was not reached — missed"
    elif cycles:
        ours, theirs = cycles["raysweep"][-1], cycles["cycles"]["seconds"]
        row.values = [theirs / ours["wall"]]
        row.note = (f"{theirs:.2f} s against {ours['wall']:.2f} s, of which {ours['light'] + ours['render']:.2f} s are "
                    "lighting and rendering")
    return row


def large_row(rounds):
    row = Row("512³ and 1024³-bounding-box clouds (5–20 % active): growth of time per sweep and active voxel from 512³ to "
              "1024³", "linear ± 15 %, within 24 GiB", "", [], 1.15)
    ends = [(volumes["510"], volumes["1020"]) for volumes in rounds if "1020" in volumes]
    if ends:
        row.values = [big["ns_per_voxel"] / small["ns_per_voxel"] for small, big in ends]
        small, big = ends[0]
        row.note = (f"memory {big['bytes_per_voxel'] / small['bytes_per_voxel']:.2f}, "
                    f"{big['peak_bytes'] / 2**30:.1f} GiB at its peak")
    return row


def outside_share(run):
    """Of the time that the report tells, what is neither direct light nor sweeps."""
    return sum(run[key] for key in ("read", "prepare", "output", "write")) / run["seconds"]


def ct_rows(runs):
    update = "SART update, 256×256×110 voxels, a view of 384×256 rays"
    return [
        Row(f"{update}, parallel, ms", "≤ 15", "≤ 8", counters(runs, "ct_parallel", "ms"), 15, form="{:.1f}"),
        Row("the same ÷ streaming the volume three times at the triad bandwidth", "≤ 2", "",
            counters(runs, "ct_parallel", "x_stream"), 2),
        Row("the same, cone, ms", "≤ 50", "≤ 20", counters(runs, "ct_cone", "ms"), 50, form="{:.1f}"),
        Row("half of the volume empty: times as fast, parallel", "≥ 1.6×", "", ratios(runs, "ms", "ct_parallel", "ct_half"),
            1.6, at_least=True, form="{:.2f}×"),
        Row("the same, cone", "≥ 1.6×", "", ratios(runs, "ms", "ct_cone", "ct_half_cone"), 1.6, at_least=True,
            form="{:.2f}×"),
        Row("cone, detector rolled by 1°, ÷ the upright one", "≤ 2", "", ratios(runs, "ms", "ct_rolled", "ct_cone"), 2),
        Row("the same by 3°", "≤ 2", "", ratios(runs, "ms", "ct_rolled_more", "ct_cone"), 2),
        Row("the same, on its side", "≤ 2", "", ratios(runs, "ms", "ct_on_side", "ct_cone"), 2),
        Row("FDK, a view filtered and backprojected, ÷ a SART update", "≤ 0.5", "",
            ratios(runs, "ms", "ct_fdk", "ct_cone"), 0.5),
    ]


def photo_rows(runs):
    one, two = "photo_consistent_1thread", "photo_consistent"
    return [
        Row("photographs, 128³: a ray's sample there and back, one thread, µs", "≤ 0.08", "",
            [1e-3 * value for value in counters(runs, "photo_fit_1thread", "ns_sample")], 0.08, form="{:.3f}"),
        Row("the same: memory of a fit, bytes per voxel that is kept", "≤ 64", "",
            counters(runs, "photo_fit_1thread", "bytes_voxel"), 64, form="{:.1f}"),
        Row("correction by a view of 256², `consistent`, two threads, ms", "≤ 20", "", counters(runs, two, "ms"), 20,
            form="{:.1f}"),
        Row("the same: 2 threads ÷ 1 thread", "≥ 1.8×", "", ratios(runs, "ms", one, two), 1.8, at_least=True,
            form="{:.2f}×"),
    ]


def cube4_rows(runs):
    return [
        Row("Cube-4 emulator, one core: sweep of 64³ voxels, 16 pipelines, floats, ms", "≤ 60", "",
            counters(runs, "cube4_64", "ms"), 60, form="{:.1f}"),
        Row("the same, 128³, ms", "≤ 500", "", counters(runs, "cube4_128", "ms"), 500, form="{:.0f}"),
        Row("the same, 64³: millions of voxel-cycles a second", "≥ 5", "",
            [1e3 / value for value in counters(runs, "cube4_64", "ns_voxel")], 5, at_least=True, form="{:.0f}"),
    ]


def rows(results):
    runs = results.get("sweep", [])
    return [
        *sweep_rows(runs),
        convergence_row(results.get("convergence", {})),
        cycles_row(results.get("cycles", {})),
        Row("empty scene parts: smoke.vdb in a box ten times as long along each axis ÷ by itself",
            "cost 0 beyond the front (≤ 1.1)", "", ratios(runs, "ms", "smoke_in_large_box", "smoke_nearest"), 1.1),
        large_row(results.get("large", [])),
        Row("`light` on smoke.vdb: time outside solving", "< 15 %", "",
            [100 * outside_share(run) for run in results.get("light", [])], 15, form="{:.1f} %"),
        *ct_rows(results.get("ct", [])),
        *photo_rows(results.get("photo", [])),
        *cube4_rows(results.get("cube4", [])),
    ]


def counter_details(runs):
    for name in sorted({name for run in runs for name in run}):
        for counter in ("ms", "ns_voxel", "ns_sample", "bytes_voxel", "x_stream"):
            values = counters(runs, name, counter)
            if values:
                yield f"{name} {counter}", values


def convergence_details(convergence):
    for line in convergence.get("summary", ()):
        for key, unit in (("all", "sweeps"), ("seconds", "seconds")):
            yield f"{unit} to 1 %, {line['case']}, {line['setting']}", [float(line[key])] if line[key] else []
        yield f"least error, {line['case']}, {line['setting']}", [float(line["least_error"])]


def cycles_details(cycles):
    if not cycles:
        return
    blender, ours = cycles["blender"], cycles["raysweep"][-1]
    yield "Cycles: mean of the pixels ÷ raysweep's", [blender["mean"] / blender["mean_raysweep"]]
    yield "Cycles: mean opacity ÷ raysweep's", [blender["opacity"] / blender["opacity_raysweep"]]
    yield "Cycles: samples to 5 % noise", [cycles["cycles"]["samples"]]
    for run in blender["runs"]:
        yield f"Cycles: noise of {run['samples']} samples", [run["noise"]]
        yield f"Cycles: seconds of {run['samples']} samples", run["seconds"]
    for key in ("all_sweeps", "wall", "light", "render", "block_error", "picture_error"):
        yield f"cloud: {key.replace('_', ' ')}", [ours[key]]


def large_details(rounds):
    for edge in rounds[0] if rounds else ():
        for key in ("voxels", "share_of_cube", "share_of_bricks", "ns_per_voxel", "bytes_per_voxel"):
            yield f"cloud {edge}³: {key.replace('_', ' ')}", [volumes[edge][key] for volumes in rounds]


def light_details(runs):
    for key in runs[0] if runs else ():
        yield f"light: {key.replace('_', ' ')}", [run[key] for run in runs]


def details(results):
    """Name and values of everything that stands behind the rows."""
    return [*(line for part in ("sweep", "ct", "photo", "cube4") for line in counter_details(results.get(part, []))),
            *convergence_details(results.get("convergence", {})),
            *cycles_details(results.get("cycles", {})), *large_details(results.get("large", [])),
            *light_details(results.get("light", []))]


def three(values, digits):
    """Median, least and largest."""
    return [f"{pick(values):.{digits}g}" for pick in (statistics.median, min, max)] if values else ["", "", ""]


def as_markdown(rows_, details_, about):
    lines = [f"# {about['date']}, commit {about['commit']}", "",
             "; ".join(f"{key}: {value}" for key, value in about.items() if key not in ("date", "commit")) + ".", "",
             "Medians; in brackets the least and the largest of the repetitions.", "",
             "| what | asked | aimed at | reached |", "| --- | --- | --- | --- |"]
    lines += [f"| {row.what} | {row.asked} | {row.aimed} | {row.reached} |" for row in rows_]
    lines += ["", "| behind it | median | least | largest |", "| --- | --- | --- | --- |"]
    for name, values in details_:
        cells = three(values, 5) if values else ["not reached", "", ""]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def as_csv(rows_, details_, about):
    """Rows first, then what stands behind them, then the machine; one line each."""
    text = io.StringIO()
    out = csv.writer(text, lineterminator="\n")
    out.writerow(["kind", "what", "asked", "aimed", "median", "least", "largest", "met", "note"])
    for row in rows_:
        met = "" if row.met is None else "yes" if row.met else "no"
        out.writerow(["row", row.what, row.asked, row.aimed, *three(row.values, 6), met, row.note])
    for name, values in details_:
        out.writerow(["detail", name, "", "", *three(values, 6), "", ""])
    for key, value in about.items():
        out.writerow(["about", key, "", "", "", "", "", "", value])
    return text.getvalue()
