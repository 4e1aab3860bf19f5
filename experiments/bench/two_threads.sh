#!/usr/bin/env bash
# Compares one process with two threads and two processes with one thread, each pinned to a processor: wall time of the
# same work, alternating.
#
#   bash experiments/bench/two_threads.sh [RAYLEX] [ROUNDS] [SPP] [SCENE.pbrt]
#                                                        default: build/release/raylex 5 256, cornell-grey
#
# Prints medians and their ratio: the cost of threads for each other within a process. Processors 0 and 1 must otherwise
# be idle.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
raylex=${1:-$root/build/release/raylex} rounds=${2:-5} spp=${3:-256}
scene=${4:-$root/experiments/scenes/cornell-grey/scene.pbrt}
[ "$(nproc)" -ge 2 ] || { echo "two_threads.sh: there is only one processor; expected two" >&2; exit 2; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# render PROCESSORS NAME FLAGS...: renders on these processors.
render() {
    local processors=$1 name=$2
    shift 2
    taskset -c "$processors" "$raylex" render "$scene" -o "$work/$name.exr" --stats "$work/$name.json" "$@" \
        >/dev/null 2>"$work/$name.log" || { cat "$work/$name.log" >&2; exit 2; }
}
for ((round = 0; round < rounds; ++round)); do
    render 0,1 both --threads 2 --spp "$spp"
    render 0 first --threads 1 --spp "$((spp / 2))" &  # half of the work each
    render 1 second --threads 1 --spp "$((spp / 2))" --seed 1
    wait $!
    python3 - "$work" >>"$work/times" <<'TIMES'
import json, sys
wall = lambda name: json.load(open(f"{sys.argv[1]}/{name}.json"))["phases"]["render"]["wall_seconds"]
print(wall("both"), max(wall("first"), wall("second")))
TIMES
done
python3 - "$work/times" <<'REPORT'
import statistics, sys
pairs = [tuple(map(float, line.split())) for line in open(sys.argv[1])]
threads, processes = (statistics.median(pair[i] for pair in pairs) for i in (0, 1))
ratios = sorted(pair[0] / pair[1] for pair in pairs)
print(f"two threads {threads:.3f} s, two processes {processes:.3f} s of rendering; "
      f"ratio {statistics.median(ratios):.3f} ({ratios[0]:.3f} to {ratios[-1]:.3f}, {len(pairs)} rounds)")
REPORT
