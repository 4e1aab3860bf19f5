"""Measures what a guide gains: efficiency 1 / (CPU time x squared error without the worst 0.1 %), medians over seeds.

    python3 experiments/bench/guiding.py PROGRAM [SCENE.pbrt...] [--size W H] [--seeds N] [--seconds S | --spp N]
                                         [--guide on|auto] [--methods NAME...]

Without scenes: door-ajar, glass-fixtures, metal-kitchen and skylight. A study renders each scene by path, by path with
a guide, and by bdpt, with one thread, each for S seconds or N samples. CPU time includes the training of the guide. The
reference of a pixel is the mean of the guided renders with other seeds. The noise of the reference, computed from the
guided errors, is subtracted. The columns are: method, CPU seconds, samples per pixel, squared error relative to the
squared mean pixel, and efficiency.
"""

import argparse
import json
import os
import pathlib
import statistics
import tempfile

from passes import ROOT, pixels, run, squared_error


def config_of(options, scene):
    budget = f"samples = [{options.spp}]" if options.spp else f"seconds = [{options.seconds}]"
    methods = {"path": '"path"', "guided": f'{{ type = "path", guide = "{options.guide}" }}', "bdpt": '"bdpt"'}
    text = [f'replicates = {options.seeds}\nthreads = 1\n[[scene]]\nname = "s"\nfile = {json.dumps(str(scene))}\n'
            f'resolution = {options.size}\n[budget]\n{budget}\n']
    text += [f'[[method]]\nname = "{name}"\nintegrator = {methods[name]}\n' for name in options.methods]
    return "\n".join(text)


def measured(options, scene, folder):
    (folder / "study.toml").write_text(config_of(options, scene))
    run([options.program, "experiment", "run", folder / "study.toml", "-o", folder / "out"], codes=(0, 1))
    renders = {name: [] for name in options.methods}
    for name, found in renders.items():
        for file in sorted((folder / "out" / "cells").glob(f"s.{name}.*/cell.json")):
            found.append((json.loads(file.read_text()), pixels(file.parent, "beauty")))
    guided = [image for _, image in renders["guided"]]
    total = [sum(values) for values in zip(*guided)]
    print(f"\n{scene.parent.name}", flush=True)
    efficiencies, noise = {}, 0  # noise: squared error of a guided render
    for name in sorted(renders, key=lambda name: name != "guided"):
        found = renders[name]
        rows = []
        for (cell, image), (_, own) in zip(found, renders["guided"]):
            count = len(guided) - 1
            error = squared_error(image, [(value - own[i]) / count for i, value in enumerate(total)])
            error = error * count / (count + 1) if name == "guided" else error - noise / count
            rows.append((cell["cpu_seconds"], cell["samples_per_pixel"], error))
        if not rows or min(row[2] for row in rows) <= 0:
            print(f"  {name:8} fails, or its error is below the noise of the reference", flush=True)
            continue
        if name == "guided":
            noise = statistics.mean(row[2] for row in rows)
        efficiencies[name] = statistics.median(1 / (row[0] * row[2]) for row in rows)
        cpu, samples, error = (statistics.median(column) for column in zip(*rows))
        learned = {cell.get("guide_samples", 0) for cell, _ in found}
        print(f"  {name:8} {cpu:8.3g} s {samples:8.0f} {error:10.3g}  {efficiencies[name]:.3g}"
              + (f"  learned from {sorted(learned)} samples" if name == "guided" else ""), flush=True)
    return efficiencies["guided"] / efficiencies["path"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    parser.add_argument("--size", type=int, nargs=2, default=[320, 180])
    parser.add_argument("--seeds", type=int, default=8, help="at least 2")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--spp", type=int)
    parser.add_argument("--guide", choices=("on", "auto"), default="on")
    parser.add_argument("--methods", nargs="+", default=["path", "guided", "bdpt"])
    options = parser.parse_args()
    if options.seeds < 2 or not {"path", "guided"} <= set(options.methods):
        parser.error("expected at least 2 seeds, and the methods path and guided")
    options.program = os.path.abspath(options.program)
    names = ("door-ajar", "glass-fixtures", "metal-kitchen", "skylight")
    gains = []
    for scene in options.scenes or [ROOT / "experiments" / "scenes" / name / "scene.pbrt" for name in names]:
        with tempfile.TemporaryDirectory() as folder:
            gains.append(measured(options, scene.resolve(), pathlib.Path(folder)))
    print(f"\ngeometric mean of guided over path: {statistics.geometric_mean(gains):.2f}, worst {min(gains):.2f}")


if __name__ == "__main__":
    main()
