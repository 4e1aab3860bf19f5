#!/usr/bin/env python3
"""Measures a render's speed for varying threads, triangles, lights, channels, depth and resolution.

    python3 experiments/bench/sweep.py [--raylex PROGRAM] [--rounds 3] [--csv FILE] [SUBJECT[=VALUE,...]...]

Without a name: all subjects. `triangles=1000,10000` uses only these values. Each round renders all values of a subject
in turn; the median over rounds is printed and, with --csv, written. Other settings: one thread, only beauty, depth 8
and 64 samples of cornell-grey. Scenes are generated into build/bench-scenes; 10^7 triangles take 3 GB of memory and
half a minute to generate.
"""
import argparse
import csv
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
GENERATED = ROOT / "build" / "bench-scenes"
GREY = ROOT / "experiments/scenes/cornell-grey/scene.pbrt"
EXPRESSIONS = (ROOT / "lpe/bench/data/lpe_bench_firsthit.txt").read_text().splitlines()

SUBJECTS = {
    "threads": [1, 2],
    "triangles": [10 ** n for n in range(3, 8)],
    "lights": [10 ** n for n in range(6)],
    "channels": [0, 1, 4, 16, 64, 256],
    "depth": [0, 1, 2, 4, 8, 16, 64],
    "resolution": [50, 100, 200, 400, 800],
}
COLUMNS = ["subject", "value", "rounds", "load_and_build_cpu_seconds", "render_wall_seconds", "render_cpu_seconds",
           "samples_per_cpu_second", "rays_per_cpu_second", "samples_per_wall_second", "peak_memory_bytes"]


def generated(name):
    """Generates a scene in a separate process; otherwise its memory would count as that of the renders started here."""
    done = subprocess.run([sys.executable, str(ROOT / "experiments/bench/scenes.py"), str(GENERATED), name], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stderr)
    return done.stdout.strip()


def job(subject, value, folder):
    """Returns the arguments of `raylex render` for one value."""
    scene, flags = GREY, {"--threads": 1, "--spp": 64, "--max-depth": 8}
    if subject == "threads":
        flags["--threads"] = value
    elif subject == "triangles":
        scene = generated(f"terrain:{value}")
        flags["--spp"] = 16
    elif subject == "lights":
        scene = generated(f"lights:{value}")
        flags.update({"--spp": 16, "--max-depth": 1})
    elif subject == "depth":
        flags["--max-depth"] = value
    elif subject == "resolution":
        flags.update({"--resolution": f"{value}x{value}", "--spp": max(16, 64 * 200 * 200 // value ** 2 // 16 * 16)})
    if subject == "channels" and value > 0:
        file = folder / f"channels-{value}.toml"
        file.write_text(f'[scene]\nfile = "{scene}"\n' + "".join(
            f'[[channel]]\nname = "c{i}"\nlpe = "{EXPRESSIONS[i % len(EXPRESSIONS)]}"\ndialect = "osl"\n' for i in range(value)))
        scene = file
    return [str(scene), *(str(word) for flag in flags.items() for word in flag)]


def measure(raylex, arguments, folder):
    stats = folder / "stats.json"
    done = subprocess.run([raylex, "render", *arguments, "-o", str(folder / "out.exr"), "--stats", str(stats)], capture_output=True,
                          text=True)
    if done.returncode != 0:
        sys.exit(f"sweep.py: raylex render {' '.join(arguments)}\nended with exit code {done.returncode}:\n{done.stderr[-2000:]}")
    found = json.loads(stats.read_text())
    phases, render = found["phases"], found["phases"]["render"]
    return [phases["load"]["cpu_seconds"] + phases["build"]["cpu_seconds"], render["wall_seconds"], render["cpu_seconds"],
            found["samples"]["per_cpu_second"], found["rays_per_cpu_second"],
            found["samples"]["camera"] / render["wall_seconds"], found["peak_memory_bytes"]]


def sweep(subject, values, options, folder):
    jobs = [job(subject, value, folder) for value in values]
    rounds = [[measure(options.raylex, arguments, folder) for arguments in jobs] for _ in range(options.rounds)]
    return [[subject, value, options.rounds, *(statistics.median(each[i][k] for each in rounds) for k in range(len(COLUMNS) - 3))]
            for i, value in enumerate(values)]


def wanted(words):
    for word in words or SUBJECTS:
        subject, equals, values = word.partition("=")
        if subject not in SUBJECTS:
            sys.exit(f"sweep.py: unknown subject '{subject}'; expected one of {', '.join(SUBJECTS)}")
        try:
            yield subject, [int(value) for value in values.split(",")] if equals else SUBJECTS[subject]
        except ValueError:
            sys.exit(f"sweep.py: '{values}' are not values of {subject}; expected integers separated by commas")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--raylex", default=str(ROOT / "build/release/raylex"))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--csv", type=pathlib.Path)
    parser.add_argument("subjects", nargs="*", metavar="SUBJECT[=VALUE,...]", help=", ".join(SUBJECTS))
    options = parser.parse_args()
    rows = []
    print(f"{'subject':11}{'value':>9}{'set-up s':>10}{'CPU s':>8}{'wall s':>8}{'M samples/CPU s':>17}{'M rays/CPU s':>14}{'memory MB':>11}")
    with tempfile.TemporaryDirectory() as folder:
        for subject, values in wanted(options.subjects):
            for row in sweep(subject, values, options, pathlib.Path(folder)):
                rows.append(row)
                _, value, _, setup, wall, cpu, samples, rays, _, memory = row
                print(f"{subject:11}{value:9}{setup:10.3f}{cpu:8.3f}{wall:8.3f}{samples / 1e6:17.3f}{rays / 1e6:14.2f}{memory / 1e6:11.0f}",
                      flush=True)
    if options.csv:
        with open(options.csv, "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(COLUMNS)
            writer.writerows(rows)


if __name__ == "__main__":
    main()
