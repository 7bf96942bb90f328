"""What the figures were measured on."""

import os
import re
import statistics
import subprocess


def first(path, pattern):
    with open(path, encoding="utf-8", errors="replace") as file:
        found = re.search(pattern, file.read(), re.MULTILINE)
    return found.group(1).strip() if found else "unknown"


def load():
    """Processes that want to run, mean of the last minute: what else the machine was doing."""
    return os.getloadavg()[0]


def compiler(root):
    command = first(root / "build" / "CMakeCache.txt", r"^CMAKE_CXX_COMPILER:\w+=(.*)$")
    version = subprocess.run([command, "--version"], capture_output=True, text=True, check=True).stdout
    return version.splitlines()[0]


def describe(root, sweep, load_before):
    kilobytes = int(first("/proc/meminfo", r"^MemTotal:\s*(\d+)"))
    triad = [run["dense_nearest"]["GB_s_triad"] for run in sweep or [] if "dense_nearest" in run]
    return {
        "CPU": first("/proc/cpuinfo", r"^model name\s*:\s*(.*)$"),
        "cores": os.cpu_count(),
        "memory": f"{kilobytes / 2**20:.0f} GiB",
        "triad": f"{statistics.median(triad):.1f} GB/s" if triad else "not measured",
        "compiler": compiler(root),
        "load before": f"{load_before:.1f}",
    }
