#!/usr/bin/env bash
# What asking for layers costs: the same render with and without them, in turn (A B A B ...), CPU time of the render phase.
#
#   bash experiments/bench/cost_of_asking.sh [RAYLEX] [ROUNDS] [SPP]     default: build/release/raylex 5 64
#
# Prints per kind of request the least and the median CPU time of a camera sample, and their ratio to beauty alone. The
# channels are the first ones of lpe/bench/data/lpe_bench_firsthit.txt (osl), which overlap: a path is in about five of 64.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
raylex=${1:-$root/build/release/raylex} rounds=${2:-5} spp=${3:-64}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# job NAME SCENE CHANNELS ANYTHING...: a job with so many channels and the lines that follow.
job() {
    local name=$1 scene=$2 count=$3
    shift 3
    {
        printf '[scene]\nfile = "%s"\n[output]\nfile = "%s"\nstats = "%s"\n' \
            "$root/experiments/scenes/$scene/scene.pbrt" "$work/$name.exr" "$work/$name.json"
        printf '[render]\nspp = %s\nthreads = 1\nmax_depth = 8\n' "$spp"
        printf '%s\n' "$@"
        # Past the end of the file the same expressions come again, each for a layer of its own.
        local expressions=$root/lpe/bench/data/lpe_bench_firsthit.txt
        cat "$expressions" "$expressions" |
            awk -v count="$count" 'NR <= count { printf "[[channel]]\nname = \"c%03d\"\nlpe = \"%s\"\ndialect = \"osl\"\n", NR, $0 }'
    } >"$work/$name.toml"
}

aovs='aovs = ["P", "Nn", "Ngn", "z", "st", "id", "albedo", "VLen", "u", "v"]'
job beauty cornell-grey 0
job channels64 cornell-grey 64
job all cornell-grey 64 '[channels]' "$aovs" '[channels.statistics]' 'beauty = ["variance"]'
job channels256 cornell-grey 256

names=(beauty channels64 all channels256)
for ((round = 0; round < rounds; ++round)); do
    for name in "${names[@]}"; do
        "$raylex" render "$work/$name.toml" >/dev/null 2>"$work/log" || { cat "$work/log" >&2; exit 1; }
        sed -n 's/.*"per_cpu_second": *\([0-9.e+]*\).*/\1/p' "$work/$name.json" | awk '{ print 1e9 / $1 }' >>"$work/$name.ns"
    done
done
for name in "${names[@]}"; do
    sort -g "$work/$name.ns" | awk -v name="$name" -v base="$(sort -g "$work/beauty.ns" | awk '{ v[NR] = $1 } END { print v[1], v[int((NR + 1) / 2)] }')" '
        { v[NR] = $1 }
        END { split(base, b, " "); m = v[int((NR + 1) / 2)]
              printf "%-12s least %7.1f ns, median %7.1f ns a sample; over beauty +%.1f ns, x%.3f (least), x%.3f (median)\n",
                     name, v[1], m, v[1] - b[1], v[1] / b[1], m / b[2] }'
done
