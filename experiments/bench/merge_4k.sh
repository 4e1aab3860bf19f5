#!/bin/bash
# Merges eight shards of 64 layers at 3840 x 2160 in two orders; measures the cost and compares the pixels.
#
#     bash experiments/bench/merge_4k.sh PROGRAM FOLDER [SIZE]
#
# Layers: the light of each of 16 lamps with 1, 2 and 3 scattering events, and seen by the camera. Records take 2.9 GB
# each, the whole FOLDER about 25; existing records are not rendered again.
set -euo pipefail
program=$(realpath "$1")
folder=$2
size=${3:-3840x2160}
scene=$(realpath "$(dirname "$0")/../scenes/cornell-lamps16/scene.pbrt")
mkdir -p "$folder"
cd "$folder"

{
    printf '[scene]\nfile = "%s"\n' "$scene"
    for lamp in $(seq 0 15); do printf '[[light_group]]\nlight = "area:%s"\ngroup = "lamp%s"\n' "$lamp" "$lamp"; done
    for lamp in $(seq 0 15); do
        for scatterings in 0 1 2 3; do
            printf '[[channel]]\nname = "lamp%s_%s"\n' "$lamp" "$scatterings"
            printf "lpe = \"C.{%s}<L.'lamp%s'>\"\n" "$scatterings" "$lamp"
        done
    done
} >job.toml
common=(--resolution "$size" --max-depth 3 --spp 128 -o out.exr)
measured() { # NAME COMMAND...
    local name=$1
    shift
    /usr/bin/time -f "$name: %e s wall, %U s user, %S s system, %M kB resident at most" "$@" >log
}

for shard in 1 2 3 4 5 6 7 8; do
    [[ -e out.exr.shard-$shard-of-8 ]] ||
        measured "shard $shard" "$program" render job.toml "${common[@]}" --shard "$shard/8" --memory 2GiB
done
du --apparent-size -ch out.exr.shard-*-of-8 | tail -1
measured "merge" "$program" merge out.exr.shard-{1,2,3,4,5,6,7,8}-of-8 -o out.exr
measured "merge in another order" "$program" merge out.exr.shard-{5,2,8,1,7,3,6,4}-of-8 -o other.exr
# Headers list the records in the order of the command line; pixels follow within the first MiB.
pixels=$(($(stat -c %s out.exr) - (1 << 20)))
cmp <(tail -c "$pixels" out.exr) <(tail -c "$pixels" other.exr)
echo "the same pixels: the last $pixels bytes of both files"
