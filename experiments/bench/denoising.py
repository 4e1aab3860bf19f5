#!/usr/bin/env python3
"""What do stated errors of denoised layers cover, and what does denoising gain at equal CPU time?

    PYTHONPATH=build/release/python python3 experiments/bench/denoising.py coverage [--seeds 50] [--spp 16] [SCENE ...]
    PYTHONPATH=build/release/python python3 experiments/bench/denoising.py gain [--spp 64] [SCENE ...]

`coverage` renders each scene with 64 x 48 pixels and many seeds, denoises it with the shipped partition, and counts how
often the mean squared error of a layer is in the interval of 95 % that the header states. `gain` compares the error of
a denoised render, at the scene's own resolution, with that of a render without denoising that takes as much CPU time.
Times are those of the whole program, and alternate.

The error of an image x is the mean of (x - a)(x - b) over pixels and components, with two independent references a and
b, so the noise of the references cancels. `trimmed` leaves out the 0.1 % of pixels with the largest errors.
"""

import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

import raylex

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ["still-life", "cornell-color", "mis-plates", "sky-image", "cornell-fog"]


def squared_errors(layer, references):
    a, b = (each.astype(float) for each in references)
    return ((layer.astype(float) - a) * (layer.astype(float) - b)).mean(axis=-1).ravel()


def trimmed(errors):
    return np.sort(errors)[: len(errors) - max(1, len(errors) // 1000)].sum() / len(errors)


def coverage(scene, arguments):
    settings = dict(resolution=(64, 48), shipped=True, spp=arguments.spp)
    references = [raylex.render(scene, **{**settings, "spp": arguments.reference, "seed": 1000 + i}) for i in (1, 2)]
    rows = {}
    for seed in range(1, arguments.seeds + 1):
        image = raylex.render(scene, **settings, seed=seed, denoise=True)
        for name, text in image.attributes.items():
            found = re.match(r"mean squared error ([^,]+), before ([^,]+), .*?from ([^ ]+) to ([^;]+);", text)
            if not name.startswith("error/") or not found:
                continue
            layer, values = name[len("error/"):], [float(each) for each in found.groups()]
            if values[1] == 0:
                continue  # no noise
            errors = squared_errors(image[layer], [each[layer] for each in references])
            rows.setdefault(layer, []).append([errors.mean(), trimmed(errors), *values])
    result = []
    for layer, values in rows.items():
        whole, without_worst, estimate, before, least, most = np.array(values).T
        inside = [(least <= each) & (each <= most) for each in (whole, without_worst)]
        ratio = whole / estimate
        print(f"  {layer:18} covered {inside[0].mean():6.1%}  trimmed {inside[1].mean():6.1%}  before {before.mean():.3g}"
              f"  after {whole.mean():.3g}  estimated {estimate.mean():.3g}  error / estimate, quantiles 5 50 95 %: "
              + " ".join(f"{each:.2f}" for each in np.quantile(ratio, (0.05, 0.5, 0.95))), flush=True)
        result.append(inside)
    return np.concatenate([each[0] for each in result]), np.concatenate([each[1] for each in result])


def cpu_seconds(*command):
    process = subprocess.Popen([str(each) for each in command], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"{command} failed")
    return usage.ru_utime + usage.ru_stime


def gain(scene, arguments):
    with tempfile.TemporaryDirectory() as folder:
        file = {name: pathlib.Path(folder) / f"{name}.exr" for name in ("denoised", "noisy")}

        def render(name, spp, *more):
            return cpu_seconds(arguments.raylex, "render", scene, "--partition", "shipped", "--spp", spp,
                               "-o", file[name], "--threads", 2, *more)
        times = {"denoised": [], "noisy": []}
        for _ in range(arguments.rounds):
            times["noisy"].append(render("noisy", arguments.spp))
            times["denoised"].append(render("denoised", arguments.spp, "--denoise"))
        load = render("noisy", 1)
        noisy, denoised = (float(np.median(times[each])) for each in ("noisy", "denoised"))
        more = round(arguments.spp * (denoised - load) / (noisy - load))
        used = render("noisy", more)
        references = [raylex.render(scene, spp=arguments.reference, seed=1000 + i)["beauty"] for i in (1, 2)]
        after, before = (trimmed(squared_errors(raylex.read(file[each])["beauty"], references))
                         for each in ("denoised", "noisy"))
    print(f"  {arguments.spp} samples {noisy:.1f} s, denoised {denoised:.1f} s, {more} samples {used:.1f} s: "
          f"error of the beauty {after:.3g} instead of {before:.3g}, ratio {after / before:.2f}", flush=True)
    return after / before


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("question", choices=["coverage", "gain"])
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--seeds", type=int, default=50)
    parser.add_argument("--spp", type=int, default=None)
    parser.add_argument("--reference", type=int, default=1024, help="samples per pixel of each reference")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--raylex", default=ROOT / "build" / "release" / "raylex")
    arguments = parser.parse_intermixed_args()
    arguments.spp = arguments.spp or (16 if arguments.question == "coverage" else 64)
    results = []
    for name in arguments.scenes:
        print(name, flush=True)
        path = ROOT / "experiments" / "scenes" / name / "scene.pbrt"
        question = coverage if arguments.question == "coverage" else gain
        results.append(question(str(path if path.exists() else name), arguments))
    if arguments.question == "coverage":
        whole, without_worst = (np.concatenate(each) for each in zip(*results))
        print(f"covered: {whole.mean():.1%} of {len(whole)} intervals; {without_worst.mean():.1%} of errors without the "
              "worst 0.1 % of pixels")
    else:
        print(f"median of the ratios: {np.median(results):.2f}")


if __name__ == "__main__":
    main()
