#!/usr/bin/env python3
"""Checks the number of instructions of the inner loops against budgets. Needs valgrind; see README.md beside this file.

    python3 experiments/bench/instructions.py [--raylex PROGRAM] [--renew] [CASE...]

Small single-thread renders run under callgrind twice, with 16 and with 48 samples per pixel. The further instructions
of the second, divided by its further camera samples, are the cost of a sample; the setup cancels. Only raylex's code
counts: shared libraries (Embree, the C library) are excluded, and Embree is restricted to SSE2, so that results do not
depend on the host, except for samplers, whose budgets are those of AVX2. Exit code 0: all within budget; 1: a loop
exceeds its budget; 2: the measurement failed.
"""
import argparse
import collections
import concurrent.futures
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
BUDGETS = HERE / "instructions.toml"
FEW, MANY, SIDE = 16, 48, 32  # samples: whole blocks of 16; pixels: whole tiles
# Counts of two runs differ by less than 0.05 %. The rest is a margin for edits elsewhere that change the compiler's
# inlining; a loop that gets 5 % more expensive is beyond it.
TOLERANCE = 0.03
# Below this number of instructions per sample, 3 % is a fraction of an instruction, in loops that hardly run.
NEGLIGIBLE = 20

SCENES = ROOT / "experiments" / "scenes"
CASES = {
    "surfaces": [str(SCENES / "cornell-grey/scene.pbrt"), "--max-depth", "8"],
    "channels": [str(SCENES / "cornell-grey/scene.pbrt"), "--max-depth", "8"],  # and 32 channels
    "textures": [str(SCENES / "still-life/scene.pbrt"), "--max-depth", "8"],
    "media": [str(SCENES / "cornell-fog/scene.pbrt"), "--max-depth", "8"],
    "many-lights": [str(SCENES / "lamps/scene.pbrt"), "--max-depth", "4"],
    "bidirectional": [str(SCENES / "cornell-color/scene.pbrt"), "--integrator", "bdpt", "--max-depth", "5"],
}
# A function belongs to the first loop that has a word in the function's name.
LOOPS = [
    ("sampler", ["Sampler", "draw_sampler_pairs", "sobol_pair"]),
    ("film", ["FrameBuffer", "RayRows", "FixedSum", "SplatGate", "add_pixel"]),
    ("channels", ["display::"]),
    ("camera", ["Camera::"]),
    ("media", ["Medium", "transmittance", "optical_depth", "sample_phase", "Phase"]),
    ("paths", ["Walk<", "Subpaths", "DirectLight", "LightEmitters", "Connections", "Record", "Integrator", "EventTable", "Bdpt",
               "PartialMisWeights", "ray_from", "weigh_importance"]),
    ("lights", ["Light", "Environment", "area_sample"]),
    ("geometry", ["EmbreeScene", "ShapeGeometry", "Quadric", "Patch", "intersect_user", "occlude_user", "Placement", "Transform"]),
    ("materials", ["Material", "Bsdf", "Texture", "Image", "Closure", "Coat", "Ggx", "fresnel", "evaluate_scattering", "LocalSample"]),
]


def fail(message):
    print(f"instructions.py: {message}", file=sys.stderr)
    sys.exit(2)


def instructions_by_function(file, program):
    """Returns {function of `program`: instructions executed in it, without callees}. Format: valgrind's manual,
    "Callgrind format specification"; numbers refer to earlier names, of functions and callees alike."""
    names = {"fn": {}, "ob": {}}

    def name_of(kind, text):
        number, _, name = text.partition(" ")
        if name:
            names[kind][number] = name
        return names[kind][number]

    counts = collections.Counter()
    function = library = None
    of_callee = False
    for line in open(file, errors="replace"):
        line = line.rstrip("\n")
        key, equals, value = line.partition("=")
        if equals and key == "fn":
            function = name_of("fn", value)
        elif equals and key == "ob":
            library = name_of("ob", value)
        elif equals and key in ("cfn", "cob"):
            name_of(key[1:], value)
        elif equals and key == "calls":
            of_callee = True  # the next line is the total cost of the call
        elif re.match(r"[0-9+*-]", line):
            if not of_callee and library == program:
                counts[function] += int(line.split()[1])
            of_callee = False
    return counts


def loop_of(function):
    own = function.split("(raylex", 1)[0].split("(std::", 1)[0]  # without the types of parameters
    for loop, words in LOOPS:
        if any(word in own for word in words):
            return loop
    return "other"


def count(program, arguments, samples, folder):
    folder.mkdir()
    out = folder / "callgrind"
    command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", program, "render", *arguments, "--spp",
               str(samples), "--resolution", f"{SIDE}x{SIDE}", "--threads", "1", "--isa", "sse2", "-o", str(folder / "out.exr")]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        fail(f"{' '.join(command)}\nended with exit code {done.returncode}:\n{done.stderr[-2000:]}")
    return instructions_by_function(out, program)


def measure(program, case, folder):
    arguments = CASES[case]
    if case == "channels":
        job = folder / "channels.toml"
        expressions = (ROOT / "lpe/bench/data/lpe_bench_firsthit.txt").read_text().splitlines()[:32]
        job.write_text(f'[scene]\nfile = "{arguments[0]}"\n' + "".join(
            f'[[channel]]\nname = "c{i}"\nlpe = "{lpe}"\ndialect = "osl"\n' for i, lpe in enumerate(expressions)))
        arguments = [str(job), *arguments[1:]]
    few = count(program, arguments, FEW, folder / f"{case}-few")
    many = count(program, arguments, MANY, folder / f"{case}-many")
    loops = collections.Counter()
    for function, instructions in many.items():
        loops[loop_of(function)] += (instructions - few[function]) / ((MANY - FEW) * SIDE * SIDE)
    loops["all"] = sum(loops.values())
    return {loop: cost for loop, cost in loops.items() if cost >= NEGLIGIBLE}


def judge(case, measured, budgets):
    """Prints one line per loop. Returns the number of loops beyond their budget."""
    worse = 0
    for loop in sorted(set(measured) | set(budgets), key=lambda name: (name == "all", name)):
        cost, budget = measured.get(loop, 0.0), budgets.get(loop, 0.0)
        change = cost / budget - 1 if budget else float("inf")
        verdict = ""
        if cost > budget * (1 + TOLERANCE):
            verdict = "  DEARER than allowed"
            worse += 1
        elif cost < budget * (1 - TOLERANCE):
            verdict = "  cheaper: --renew lowers the budget"
        print(f"{case:14} {loop:10} budget {budget:8.1f}  measured {cost:8.1f}  {change:+7.2%}{verdict}")
    return worse


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--raylex", default=str(ROOT / "build/release/raylex"))
    parser.add_argument("--renew", action="store_true", help="writes the measured numbers as the budgets")
    parser.add_argument("cases", nargs="*", metavar="CASE", help=", ".join(CASES))
    options = parser.parse_args()
    for case in options.cases:
        if case not in CASES:
            fail(f"unknown case '{case}'; expected one of {', '.join(CASES)}")
    if shutil.which("valgrind") is None:
        fail("valgrind is not installed (Debian: valgrind)")
    if "avx2" not in pathlib.Path("/proc/cpuinfo").read_text().split():
        fail("this processor has no AVX2, which the budgets require")
    program = os.path.realpath(options.raylex)
    if not os.access(program, os.X_OK):
        fail(f"program {program} not found; expected a Release build: cmake --build --preset release --target raylex")
    cases = options.cases or list(CASES)
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        results = dict(zip(cases, pool.map(lambda case: measure(program, case, pathlib.Path(folder)), cases)))
    budgets = tomllib.loads(BUDGETS.read_text()) if BUDGETS.exists() else {}
    if options.renew:
        budgets.update(results)
        lines = ["# Instructions a camera sample, Release build of g++ 12.2: written by `instructions.py --renew`."]
        for case in CASES:
            if case in budgets:
                lines += [f"\n[{case}]"] + [f"{loop} = {cost:.1f}" for loop, cost in sorted(budgets[case].items())]
        BUDGETS.write_text("\n".join(lines) + "\n")
        print(f"{BUDGETS.relative_to(ROOT)}: budgets of {', '.join(cases)}")
        return 0
    worse = sum(judge(case, results[case], budgets.get(case, {})) for case in cases)
    if worse:
        print(f"{worse} loops execute over {TOLERANCE:.0%} more instructions a sample than {BUDGETS.relative_to(ROOT)} allows. If\n"
              "this is intended, run instructions.py --renew, and state the benefit in the commit message.")
    return 1 if worse else 0


if __name__ == "__main__":
    sys.exit(main())
