#!/usr/bin/env python3
"""Profiles a render: CPU nanoseconds per camera sample, by kernel, sampled by perf (Debian: linux-perf).

    python3 experiments/bench/profile.py [--raylex PROGRAM] SCENE.pbrt|JOB.toml [FLAGS OF raylex render...]

One thread. The kernels are those of instructions.py and the shared libraries; Embree is the kernel of rays. If the
processor's counters are not available, perf uses a timer. The profile includes loading the scene, so a render should
take some seconds (--spp).
"""
import collections
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from instructions import ROOT, loop_of


def fail(message):
    print(f"profile.py: {message}", file=sys.stderr)
    sys.exit(2)


def record(command, folder):
    """Returns perf's samples by (library, function), as fractions."""
    data = str(folder / "perf.data")
    for event in ("cycles:u", "cpu-clock:u"):
        done = subprocess.run(["perf", "record", "-q", "-F", "997", "-e", event, "-o", data, *command], capture_output=True, text=True)
        if done.returncode == 0:
            break
    else:
        fail(f"perf record {' '.join(command)}\nended with exit code {done.returncode}:\n{done.stderr[-2000:]}")
    report = subprocess.run(["perf", "report", "-i", data, "--stdio", "--no-children", "-F", "overhead,dso,symbol", "-w", "0,40,0"],
                            capture_output=True, text=True).stdout
    shares = collections.Counter()
    for line in report.splitlines():
        found = re.match(r"\s*([0-9.]+)%\s+(\S+)\s+\[[.k]\]\s+(.*)", line)
        if found:
            shares[found.group(2), found.group(3).strip()] += float(found.group(1)) / 100
    if not shares:
        fail("perf took no samples; expected a render of some seconds")
    return shares


def main():
    arguments = sys.argv[1:]
    program = str(ROOT / "build/release/raylex")
    if arguments[:1] == ["--raylex"]:
        program, arguments = arguments[1], arguments[2:]
    if not arguments or arguments[0] in ("-h", "--help"):
        print(__doc__)
        return
    if shutil.which("perf") is None:
        fail("perf is not installed (Debian: linux-perf)")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        stats = folder / "stats.json"
        shares = record([program, "render", *arguments, "--threads", "1", "-o", str(folder / "out.exr"), "--stats", str(stats)], folder)
        found = json.loads(stats.read_text())
    own = os.path.basename(program)
    kernels = collections.Counter()
    for (library, function), share in shares.items():
        kernels[loop_of(function) if library == own else library] += share
    seconds = sum(phase["cpu_seconds"] for phase in found["phases"].values())
    nanoseconds = 1e9 * seconds / found["samples"]["camera"]
    print(f"{nanoseconds:.0f} ns a camera sample, of {found['samples']['camera']:,}; {found['rays']['total'] / found['samples']['camera']:.2f} rays each")
    for kernel, share in kernels.most_common():
        if share >= 0.002:
            print(f"{kernel:24} {share * nanoseconds:8.1f} ns {share:7.1%}")


if __name__ == "__main__":
    main()
