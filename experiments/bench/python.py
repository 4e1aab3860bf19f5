"""Measures the cost of Python: a render compared with the program, a 4K frame's arrays, an integrator and a texture in
NumPy.

    PYTHONPATH=build/release/python python3 experiments/bench/python.py [PROGRAM]

CPU time, so that other work on the machine matters little; the minimum of several alternating runs.
"""

import pathlib
import resource
import subprocess
import sys
import tempfile
import time

import numpy as np

import raylex

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = str(ROOT / "experiments" / "scenes" / "cornell-grey" / "scene.pbrt")
RUNS = 7


def cpu(who):
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


def spent(work, who):
    before = cpu(who)
    work()
    return cpu(who) - before


def overhead(program, folder):
    arguments = ["--spp", "64", "--resolution", "256x256", "--lpe", "direct=CDL", "--aov", "Nn"]

    def by_program():
        subprocess.run([program, "render", SCENE, "-o", folder / "a.exr", *arguments], check=True, capture_output=True)

    def by_python():
        image = raylex.render(SCENE, spp=64, resolution=(256, 256), lpe={"direct": "CDL"}, aovs=["Nn"],
                              output=folder / "b.exr", progress=lambda now: None)
        image.verify()

    theirs, ours = [], []
    for _ in range(RUNS):
        theirs.append(spent(by_program, resource.RUSAGE_CHILDREN))
        ours.append(spent(by_python, resource.RUSAGE_SELF))
    more = min(ours) / min(theirs) - 1
    print(f"a render: program {min(theirs):.3f} CPU s, from Python {min(ours):.3f} CPU s: {more:+.2%}")


def handing_over():
    image = raylex.render(SCENE, spp=1, resolution=(3840, 2160), lpe={"direct": "CDL"}, aovs=["Nn", "z"])
    begin = time.perf_counter()
    arrays = {name: image[name] for name in image}
    taken = time.perf_counter() - begin
    size = sum(each.nbytes for each in arrays.values())
    print(f"{len(arrays)} layers of {image.width}x{image.height}, {size / 1e6:.0f} MB: {taken * 1e3:.3f} ms")


@raylex.texture("bench_checks")
class Checks:
    def evaluate(self, at):
        return np.repeat((np.floor(at.uv * 8).sum(axis=1) % 2)[:, None], 3, axis=1)


def floor(kind):
    builder = raylex.SceneBuilder()
    builder.film("rgb", xresolution=128, yresolution=128)
    builder.camera("perspective", eye=(0, 0, 0), look=(0, 0, 1), fov=40)
    builder.light("point", I=(10.0,) * 3)
    more = {"uscale": 8.0, "vscale": 8.0} if kind == "checkerboard" else {}
    builder.texture("checks", "spectrum", kind, **more)
    quad = np.array([[-2, -2, 1], [2, -2, 1], [2, 2, 1], [-2, 2, 1]], np.float32)
    uvs = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    builder.mesh(quad, [[0, 1, 2], [0, 2, 3]], uvs=uvs,
                 material=builder.material("diffuse", reflectance=("texture", "checks")))
    return builder.finish()


def rate(scene, **more):
    def work():
        return raylex.render(scene, spp=32, **more)

    samples = work().statistics["camera_samples"]
    return samples / min(spent(work, resource.RUSAGE_SELF) for _ in range(3)) / 1e6


def plugins():
    sys.path.insert(0, str(ROOT / "tests" / "python"))
    import test_plugins  # noqa: F401  registers test_path, a path tracer in NumPy
    for depth in (1, 5):
        more = {"resolution": (128, 128), "max_depth": depth}
        in_cpp, in_python = (rate(SCENE, integrator=each, **more) for each in ("path", "test_path"))
        share = in_python / in_cpp
        print(f"paths of {depth}: C++ {in_cpp:.2f}, NumPy {in_python:.2f} M samples a CPU second: {share:.2f}")
    plain, own = (rate(floor(each), max_depth=1) for each in ("checkerboard", "bench_checks"))
    print(f"a checkerboard: C++ {plain:.2f}, NumPy {own:.2f} M samples a CPU second: {own / plain:.2f}")


if __name__ == "__main__":
    program = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build" / "release" / "raylex"
    with tempfile.TemporaryDirectory() as folder:
        overhead(program, pathlib.Path(folder))
    handing_over()
    plugins()
