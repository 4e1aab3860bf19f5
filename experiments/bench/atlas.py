"""Measures the cost of path atlases: the CPU time to store one, the size of its file, and the time of `raylex ask`.

    python3 experiments/bench/atlas.py PROGRAM [SCENE.pbrt|JOB.toml...] [--size WxH] [--spp N] [--runs N]

Without scenes: all of experiments/scenes, and the quickstart's window-light. One thread. A render with an atlas and one
layer is compared with one without the atlas: minimum CPU times of several alternating runs, including reading and
checking the file.
"""

import argparse
import os
import pathlib
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]


def cpu_of(command):
    """Returns user and system time of a command together, user time alone, and the command's output."""
    before = os.times()
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    after = os.times()
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    user = after.children_user - before.children_user
    return user + after.children_system - before.children_system, user, done.stdout


def scenes():
    return [*sorted((ROOT / "experiments" / "scenes").glob("*/scene.pbrt")),
            ROOT / "experiments" / "quickstart" / "window-light.toml"]


def measured(program, scene, options, folder):
    width, height = map(int, options.size.split("x"))
    render = [program, "render", scene, "--resolution", options.size, "--spp", options.spp, "--threads", "1",
              "--lpe", "direct=C<RD>L", "-o", folder / "out.exr"]
    with_atlas, without, asking = [], [], []
    atlas = folder / "a.atlas.exr"
    for _ in range(options.runs):
        without.append(cpu_of(render)[:2])
        with_atlas.append(cpu_of([*render, "--atlas", atlas])[:2])
    for _ in range(options.runs):
        spent, _, said = cpu_of([program, "ask", atlas, "--partition", "shipped", "--light-groups", "-o", folder / "l.exr"])
        asking.append(spent)
    pixels = width * height
    ratio, of_user = (min(run[k] for run in with_atlas) / min(run[k] for run in without) for k in (0, 1))
    return {"ratio": ratio, "of_user": of_user, "bytes": atlas.stat().st_size / pixels,
            "words": int(said.split(" from ")[-1].split(" ")[0].replace(",", "")),
            "ask": min(asking), "ask_megapixel": min(asking) * 1e6 / pixels}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    parser.add_argument("--size", default="400x300")
    parser.add_argument("--spp", default="32")
    parser.add_argument("--runs", type=int, default=3)
    options = parser.parse_args()
    options.program = options.program.resolve()
    print("| scene | render with an atlas over one layer alone, CPU time | user time | bytes a pixel | words | `ask`, CPU s | s a megapixel |")
    print("|---|---|---|---|---|---|---|")
    for scene in options.scenes or scenes():
        name = scene.parent.name if scene.name == "scene.pbrt" else scene.stem
        with tempfile.TemporaryDirectory() as folder:
            found = measured(options.program, scene.resolve(), options, pathlib.Path(folder))
        print(f"| {name} | {found['ratio']:.2f} | {found['of_user']:.2f} | {found['bytes']:.0f} | {found['words']:,} | {found['ask']:.2f} | "
              f"{found['ask_megapixel']:.2f} |", flush=True)


if __name__ == "__main__":
    main()
