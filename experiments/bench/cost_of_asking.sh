#!/usr/bin/env bash
# The cost of requested layers: the same render with and without them, alternating (A B A B ...), CPU time of the render
# phase.
#
#   bash experiments/bench/cost_of_asking.sh [RAYLEX] [ROUNDS] [SPP]     default: build/release/raylex 5 64
#
# Prints per kind of request the minimum and the median CPU time of a camera sample, and their ratio to beauty alone.
# The channels are the first ones of lpe/bench/data/lpe_bench_firsthit.txt (osl), which overlap: a path is in about five
# of 64. The still life, with four more point lights, has the split by 8 light groups x (4 lobes x direct and indirect).
#
# Then a production's requests, by whole runs on all cores (CPU and wall time, with files written and read back): a room
# with 8 lights and a glossy box, 400 x 400, in 8 light groups x first lobe x direct or indirect (32 layers and the
# rest), 5 AOVs and an object cryptomatte, compared with the beauty alone.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
raylex=${1:-$root/build/release/raylex} rounds=${2:-5} spp=${3:-64}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# job NAME SCENE CHANNELS ANYTHING...: writes a job with this number of channels and further lines.
job() {
    local name=$1 scene=$2 count=$3
    shift 3
    {
        printf '[scene]\nfile = "%s"\n[output]\nfile = "%s"\nstats = "%s"\n' \
            "$root/experiments/scenes/$scene/scene.pbrt" "$work/$name.exr" "$work/$name.json"
        printf '[render]\nspp = %s\nthreads = 1\nmax_depth = 8\n' "$spp"
        printf '%s\n' "$@"
        # Beyond the end of the file the same expressions repeat, each with its own layer.
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

{
    printf 'Include "%s"\n' "$root/experiments/scenes/still-life/scene.pbrt"
    for x in -2 -1 0 1; do printf 'LightSource "point" "rgb I" [.5 .5 .5] "point3 from" [%s 3 2]\n' "$x"; done
} >"$work/still.pbrt"
job still still-life 0
number=0
for light in spot:0 infinite:0 point:0 point:1 point:2 point:3 area:0 area:1; do
    printf '[[light_group]]\nlight = "%s"\ngroup = "g%d"\n' "$light" $((number++))
done >>"$work/still.toml"
sed -i "s|^file = .*scene.pbrt\"|file = \"$work/still.pbrt\"|; s|^max_depth = .*|max_depth = 10|" "$work/still.toml"
sed -E "s#$work/still[.](exr|json)#$work/still_split.\1#" "$work/still.toml" >"$work/still_split.toml"
"$raylex" lpe split --by light-group,lobe,bounce --groups g0,g1,g2,g3,g4,g5,g6,g7 --lobes RD,RS,TD,TS --bounces 2 --no-volume \
    -o "$work/split.toml" 2>/dev/null
cat "$work/split.toml" >>"$work/still_split.toml"

{
    sed -n '/AreaLightSource/q; s/cornell-grey.exr/cornell8.exr/; s/resolution" 200/resolution" 400/g; /AttributeBegin/!p' \
        "$root/experiments/scenes/cornell-grey/scene.pbrt" |
        awk '{ line[NR] = $0 } END { for (i = 1; i < NR; ++i) print line[i]
            print "Material \"conductor\" \"spectrum eta\" [200 0.2 900 0.2] \"spectrum k\" [200 3.9 900 3.9] \"float roughness\" 0.2 \"bool remaproughness\" false"
            print line[NR] }'
    for z in -0.4 0.4; do
        for x in -0.75 -0.25 0.25 0.75; do
            printf 'AttributeBegin AreaLightSource "diffuse" "rgb L" [12 12 12] Material "diffuse" "rgb reflectance" [0 0 0]\n'
            printf 'Translate %s 1.98 %s Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]\n' "$x" "$z"
            printf '"point3 P" [-.1 0 -.1 .1 0 -.1 .1 0 .1 -.1 0 .1] AttributeEnd\n'
        done
    done
} >"$work/cornell8.pbrt"
for name in alone show; do
    printf '[scene]\nfile = "%s"\n[output]\nfile = "%s"\n[render]\nspp = %s\nmax_depth = 8\n' \
        "$work/cornell8.pbrt" "$work/$name.exr" "$spp" >"$work/$name.toml"
done
{
    printf '[channels]\naovs = ["P", "Nn", "z", "albedo", "st"]\ncryptomatte = ["object"]\n'
    for light in 0 1 2 3 4 5 6 7; do
        printf '[[light_group]]\nlight = "area:%s"\ngroup = "g%s"\n' "$light" "$light"
        for lobe in RD RS; do
            printf '[[channel]]\nname = "g%s_%s_direct"\nlpe = "C<%s><L.%sg%s%s>"\n' "$light" $lobe $lobe "'" "$light" "'"
            printf '[[channel]]\nname = "g%s_%s_indirect"\nlpe = "C<%s>.+<L.%sg%s%s>"\n' "$light" $lobe $lobe "'" "$light" "'"
        done
    done
} >>"$work/show.toml"

names=(beauty channels64 all channels256 still still_split)
for ((round = 0; round < rounds; ++round)); do
    for name in "${names[@]}"; do
        "$raylex" render "$work/$name.toml" >/dev/null 2>"$work/log" || { cat "$work/log" >&2; exit 1; }
        sed -n 's/.*"per_cpu_second": *\([0-9.e+]*\).*/\1/p' "$work/$name.json" | awk '{ print 1e9 / $1 }' >>"$work/$name.ns"
    done
done
for name in "${names[@]}"; do
    alone=beauty
    case $name in still*) alone=still ;; esac
    sort -g "$work/$name.ns" | awk -v name="$name" -v base="$(sort -g "$work/$alone.ns" | awk '{ v[NR] = $1 } END { print v[1], v[int((NR + 1) / 2)] }')" '
        { v[NR] = $1 }
        END { split(base, b, " "); m = v[int((NR + 1) / 2)]
              printf "%-12s least %7.1f ns, median %7.1f ns a sample; over beauty +%.1f ns, x%.3f (least), x%.3f (median)\n",
                     name, v[1], m, v[1] - b[1], v[1] / b[1], m / b[2] }'
done

TIMEFORMAT='%U %S %R'
for ((round = 0; round < rounds; ++round)); do
    for name in alone show; do
        { time "$raylex" render "$work/$name.toml" >/dev/null 2>"$work/log"; } 2>"$work/seconds" || { cat "$work/log" >&2; exit 1; }
        awk '{ print $1 + $2 }' "$work/seconds" >>"$work/$name.cpu"
        awk '{ print $3 }' "$work/seconds" >>"$work/$name.wall"
    done
done
for clock in cpu wall; do
    paste <(sort -g "$work/alone.$clock") <(sort -g "$work/show.$clock") | awk -v clock=$clock '
        { a[NR] = $1; s[NR] = $2 }
        END { m = int((NR + 1) / 2)
              printf "show, %-4s median %.2f s over %.2f s for the beauty alone: x%.3f (least: x%.3f)\n",
                     clock, s[m], a[m], s[m] / a[m], s[1] / a[1] }'
done
