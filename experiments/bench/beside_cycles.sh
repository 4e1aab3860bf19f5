#!/usr/bin/env bash
# Cycles compared with raylex: path tracing of the same scenes by both, alternating (A B A B ...), one thread each.
#
#   bash experiments/bench/beside_cycles.sh [RAYLEX] [ROUNDS] [SPP] [SCENE...]
#                                                           default: build/release/raylex 5 32 cornell8 terrain
#
# Prints per scene the median camera samples per CPU second of both, without setup, and the median of each round's
# ratio; the ratio of the images' means, which must be near 1, otherwise the scenes differ; and the remaining error of
# each (relmse-mean against an image by raylex with 16 times the samples, whose own error is a sixteenth).
# Needs Blender (Debian: blender) and Python; scenes are generated into build/bench-scenes.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(dirname "$(dirname "$here")")
raylex=${1:-$root/build/release/raylex} rounds=${2:-5} spp=${3:-32}
shift $(($# < 3 ? $# : 3))
scenes=("${@:-}")
[ -n "${scenes[0]}" ] || scenes=(cornell8 terrain)
for tool in blender python3; do
    command -v "$tool" >/dev/null || { echo "beside_cycles.sh: $tool is not installed (Debian: $tool)" >&2; exit 2; }
done
[ -x "$raylex" ] || { echo "beside_cycles.sh: program $raylex not found; expected a Release build" >&2; exit 2; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# cycles SCENE SEED: prints the CPU seconds of rendering by Cycles.
cycles() {
    local image="$work/cycles.$2.exr"
    blender -b --factory-startup --python "$here/cycles.py" -- "$1" "$spp" "$2" "$image" >"$work/log" 2>&1 &&
        sed -n 's/^CYCLES .*cpu_seconds=\([0-9.]*\).*/\1/p' "$work/log" | grep . || { cat "$work/log" >&2; exit 2; }
}
# ours SCENE SEED SAMPLES: prints the CPU seconds of rendering by raylex.
ours() {
    "$raylex" render "$root/build/bench-scenes/${1//:/-}.pbrt" --threads 1 --spp "$3" --seed "$2" \
        -o "$work/raylex.$2.exr" --stats "$work/stats.json" >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 2; }
    python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["phases"]["render"]["cpu_seconds"])' \
        "$work/stats.json"
}
metric() { "$raylex" compare --metric "$1" "$2" "$3" | grep -oE '[0-9][0-9.e+-]*' | head -n 1; }

for scene in "${scenes[@]}"; do
    python3 "$here/scenes.py" "$root/build/bench-scenes" "$scene" >/dev/null
    : >"$work/times"
    for ((round = 1; round <= rounds; ++round)); do
        echo "$(cycles "$scene" "$round") $(ours "$scene" "$round" "$spp")" >>"$work/times"
    done
    python3 - "$scene" "$spp" "$work/times" <<'REPORT'
import statistics, sys
scene, spp, file = sys.argv[1], int(sys.argv[2]), sys.argv[3]
pairs = [tuple(map(float, line.split())) for line in open(file)]
samples = 400 * 400 * spp / 1e6
cycles, ours = (statistics.median(samples / pair[i] for pair in pairs) for i in (0, 1))
ratios = sorted(pair[0] / pair[1] for pair in pairs)
print(f"{scene}: Cycles {cycles:.3f}, raylex {ours:.3f} M samples per CPU second; "
      f"ratio {statistics.median(ratios):.2f} ({ratios[0]:.2f} to {ratios[-1]:.2f}, {len(pairs)} rounds)")
REPORT
    ours "$scene" 1000 $((16 * spp)) >/dev/null
    for who in cycles raylex; do
        image="$work/$who.1.exr" reference="$work/raylex.1000.exr"
        echo "$scene: $who has mean $(metric mean-ratio "$image" "$reference") of the reference's," \
            "relmse-mean $(metric relmse-mean "$image" "$reference") at $spp samples"
    done
done
