"""Measures what passes gain: efficiency 1 / (CPU time x squared error without the worst 0.1 %), as medians over seeds.

    python3 experiments/bench/passes.py PROGRAM [SCENE.pbrt...] [--side N] [--seeds N] [--reference N] [--spp N]

Without scenes: glass-caustic, caustic-ball and window-light. A study renders each method on each scene: path,
lighttracer and bdpt alone; caustics on surfaces by lighttracer or by bdpt with the rest by path; and what `raylex passes
--propose` proposes. The reference has the proposed passes, with --reference times their samples. Errors are squared, and relative to
the squared mean pixel. The columns are: method, CPU time x error of the beauty, the same of the layer of caustics,
and, for the proposal, the forecast of error and CPU time relative to what was measured.
"""

import argparse
import array
import json
import os
import pathlib
import re
import statistics
import subprocess
import tempfile
import tomllib

ROOT = pathlib.Path(__file__).resolve().parents[2]
SINGLE = {"bdpt", "path", "lighttracer"}
CAUSTICS = "C[<RG><TG>DV]<[RT][^DG]>+[<L.>O]"


def run(command, codes=(0,)):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode not in codes:
        raise SystemExit(f"{command}\n{done.stdout}{done.stderr}")


def pixels(directory, channel):
    """Returns the values of an .npy file of float64."""
    data = (directory / f"{channel}.mean.npy").read_bytes()
    begin = 10 + int.from_bytes(data[8:10], "little")
    return array.array("d", data[begin:])


def squared_error(image, reference):
    """Returns the mean squared error without the worst 0.1 % of pixels, relative to the squared mean pixel."""
    mean = sum(reference) / len(reference)
    terms = sorted(sum((image[i + c] - reference[i + c]) ** 2 for c in range(3)) for i in range(0, len(image), 3))
    kept = terms[:len(terms) - round(len(terms) / 1000)]
    return sum(kept) / (3 * len(kept)) / (mean * mean) if mean > 0 else float("nan")


def table(passes):
    return "passes = [" + ", ".join(
        "{ " + ", ".join(f"{key} = {json.dumps(value)}" for key, value in each.items()) + " }" for each in passes) + "]"


def methods_of(spp):
    single = {name: [{"method": name, "takes": "rest", "spp": count}]
              for name, count in (("bdpt", spp), ("path", 2 * spp), ("lighttracer", 2 * spp))}
    for name, label, count in (("lighttracer", "lighttracer", 8 * spp), ("lighttracer", "few-light-paths", spp // 2),
                               ("bdpt", "bdpt", spp)):
        single[f"caustics-by-{label}"] = [{"method": "path", "takes": "rest", "spp": spp},
                                         {"method": name, "takes": CAUSTICS, "spp": count}]
    return single


def proposed(options, scene, size, folder):
    """Returns the passes that are proposed, and the forecast of their error."""
    job = folder / "job.toml"
    job.write_text(f'[scene]\nfile = {json.dumps(str(scene))}\n[render]\nresolution = {size}\n')
    run([options.program, "passes", job, "--propose", "--spp", 2 * options.spp, "-o", folder / "proposed.toml"])
    text = (folder / "proposed.toml").read_text()
    passes = tomllib.loads(text)["pass"]
    rows = re.findall(r"^# ([a-z ]+): ([\d.e+-]+) CPU s, squared error ([\d.e+-]+) ", text, re.MULTILINE)
    forecast = next((row for row in rows if row[0] == "all passes"), rows[0])
    return passes, float(forecast[1]), float(forecast[2])


def measured(options, scene, folder):
    print(f"\n{scene.parent.name}: CPU time x error of beauty, and of caustics", flush=True)
    film = re.search(r'xresolution"[ \[]*(\d+).*?yresolution"[ \[]*(\d+)', scene.read_text(), re.DOTALL)
    width, height = (int(film[1]), int(film[2])) if film else (1280, 720)
    size = [round(side * options.side / max(width, height)) for side in (width, height)]
    passes, seconds, error = proposed(options, scene, size, folder)
    methods = methods_of(options.spp) | {"proposed": passes}
    config = [f'replicates = {options.seeds}\nthreads = 1\n[[scene]]\nname = "s"\nfile = {json.dumps(str(scene))}\n'
              f'resolution = {size}\n[[channel]]\nname = "caustics"\nlpe = "{CAUSTICS}"\n[budget]\nsamples = [1]\n'
              f'[[method]]\nname = "reference"\n{table(passes)}\n[[exclude]]\nmethod = "reference"\nsamples = true\n'
              f'[reference]\nmethod = "reference"\nspp = {options.reference}\n']
    config += [f'[[method]]\nname = "{method}"\n{table(each)}\n' for method, each in methods.items()]
    (folder / "study.toml").write_text("\n".join(config))
    # Cells of a method that misses paths of the scene fail.
    run([options.program, "experiment", "run", folder / "study.toml", "-o", folder / "out"], codes=(0, 1, 2))
    reference = next((folder / "out" / "references").glob("*/beauty.mean.npy")).parent
    truth = {channel: pixels(reference, channel) for channel in ("beauty", "caustics")}
    products = {}
    for method in methods:
        rows = []
        for file in sorted((folder / "out" / "cells").glob(f"s.{method}.*/cell.json")):
            errors = [squared_error(pixels(file.parent, channel), values) for channel, values in truth.items()]
            rows.append((json.loads(file.read_text())["cpu_seconds"], *errors))
        if not rows:
            print(f"  {method:24} misses paths")
            continue
        cpu, beauty, caustics = (statistics.median(column) for column in zip(*rows))
        products[method] = statistics.median(row[0] * row[1] for row in rows)
        note = f"  forecast / measured: error {error / beauty:.2f}, CPU time {seconds / cpu:.2f}"
        print(f"  {method:24} {products[method]:.3g}  {statistics.median(row[0] * row[2] for row in rows):.3g}"
              f"  ({cpu:.3g} s, {beauty:.3g}, {caustics:.3g})" + (note if method == "proposed" else ""), flush=True)
    best = min((products[name], name) for name in SINGLE if name in products)
    for method in products.keys() - SINGLE:
        print(f"  {method} over {best[1]} alone: {best[0] / products[method]:.2f}")
    if len(passes) == 1:
        print(f"  one pass is proposed, by {passes[0]['method']}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    parser.add_argument("--side", type=int, default=96, help="longer side of the images in pixels")
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--spp", type=int, default=32, help="samples per pixel of bdpt; others have more")
    parser.add_argument("--reference", type=int, default=64)
    options = parser.parse_args()
    options.program = os.path.abspath(options.program)
    names = ("glass-caustic", "caustic-ball", "window-light")
    for scene in options.scenes or [ROOT / "experiments" / "scenes" / name / "scene.pbrt" for name in names]:
        with tempfile.TemporaryDirectory() as folder:
            measured(options, scene.resolve(), pathlib.Path(folder))


if __name__ == "__main__":
    main()
