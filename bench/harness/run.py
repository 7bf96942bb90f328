"""Measures, and stores a table. Called by bench/run.sh, which builds first."""

import argparse
import datetime
import json
import shutil
import subprocess
from pathlib import Path

import chart
import machine
import table
from parts import PARTS, Context

ROOT = Path(__file__).resolve().parents[2]


def parse_arguments():
    parser = argparse.ArgumentParser(prog="bench/run.sh", description="Measures speed and accuracy against time.")
    parser.add_argument("--only", metavar="PART,...", default=",".join(PARTS),
                        help=f"parts to run, of {', '.join(PARTS)}; rows of others are taken from an earlier run of "
                        "the same commit, if it had no changes")
    parser.add_argument("--quick", action="store_true",
                        help="fewer repetitions and smaller volumes, to see that it works; nothing is stored")
    args = parser.parse_args()
    args.only = args.only.split(",")
    for part in args.only:
        if part not in PARTS:
            parser.error(f"--only: there is no part '{part}', only {', '.join(PARTS)}")
    return args


def git(*arguments):
    return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()


def work_folder(commit, dirty, quick):
    """Where raw results lie. Those of changed sources belong to nothing that could be had again."""
    folder = ROOT / "build" / "bench" / (commit + ("-dirty" if dirty else "") + ("-quick" if quick else ""))
    if dirty:
        shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def store(stem, markdown, csv):
    folder = ROOT / "bench" / "results"
    folder.mkdir(exist_ok=True)
    (folder / f"{stem}.md").write_text(markdown)
    (folder / f"{stem}.csv").write_text(csv)
    return folder / f"{stem}.md"


def main():
    args = parse_arguments()
    commit = git("rev-parse", "--short=8", "HEAD")
    dirty = bool(git("status", "--porcelain", "--", "lib", "apps", "bench", "cmake", "CMakeLists.txt",
                     ":!bench/results"))
    folder = work_folder(commit, dirty, args.quick)
    before = machine.load()
    for part in args.only:
        print(f"== {part}", flush=True)
        result = PARTS[part](Context(root=ROOT, folder=folder, quick=args.quick))
        (folder / f"{part}.json").write_text(json.dumps(result, indent=1) + "\n")
    results = {part: json.loads(file.read_text()) for part in PARTS if (file := folder / f"{part}.json").exists()}
    about = machine.describe(ROOT, results.get("sweep"), before)
    about["commit"] = commit + (", with changes" if dirty else "")
    about["date"] = datetime.date.today().isoformat()
    rows, details = table.rows(results), table.details(results)
    markdown, csv = table.as_markdown(rows, details, about), table.as_csv(rows, details, about)
    print(markdown)
    if args.quick:
        print("quick: not stored")
        return
    stored = store(f"{about['date']}-{commit}" + ("-dirty" if dirty else ""), markdown, csv)
    print(f"stored: {stored.relative_to(ROOT)}, {stored.with_suffix('.csv').name}")
    if "sweep" in results:
        print(f"chart: {chart.draw(stored.with_suffix('.csv'), ROOT / 'docs' / 'images' / 'sweep.svg')}")


if __name__ == "__main__":
    main()
