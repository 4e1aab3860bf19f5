#!/usr/bin/env bash
# From a clone to pictures: installs missing packages, builds what renders, and shows a coarse picture of a still life,
# which it refines while it builds the rest. Then it renders the still life and a colonnade in fog with all layers,
# denoises them, checks that the layers still sum to the beauty, runs a small study of accuracy against time, and writes
# images, previews and two HTML pages.
#
#   bash experiments/quickstart.sh [OUT]     OUT defaults to build/quickstart in the clone
#
# Finished steps are skipped on a rerun. Earlier results are moved to OUT/earlier-... when they are made again.
# Exit codes: 0 every split holds, 1 a split does not hold, 2 something is missing or failed, 130 after Ctrl-C.
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(dirname "$here")
scenes=(window-light lantern-fog)

case "${1:-}" in
    -h | --help) sed -n '2,10s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    -*) echo "quickstart.sh: unknown option '$1'; expected a folder for the results, or nothing" >&2; exit 2 ;;
esac
[ $# -le 1 ] || { echo "quickstart.sh: $# arguments; expected at most one folder" >&2; exit 2; }
out=${1:-$root/build/quickstart}

# CPU seconds and megabytes, measured on a machine with two cores and a cold compiler cache. The probe compiles one file
# on every core of this machine: the time that it takes, over probe_seconds, is how much slower this machine is now.
probe_seconds=2.3
first_core_seconds=430
rest_core_seconds=350
render_core_seconds=80
study_core_seconds=110
needed_megabytes=2200

say() { printf '%s\n' "$*"; }
refining=""
stop() { printf 'quickstart.sh: %s\n' "$*" >&2; stop_refining; exit 2; }
stop_refining() { [ -z "$refining" ] || { kill "$refining"; wait "$refining"; refining=""; } 2>/dev/null; }
interrupted() {
    stop_refining
    say $'\n'"Interrupted. Finished work is kept; the same command continues from there."
    exit 130
}
trap interrupted INT TERM
minutes() { awk -v s="$1" 'BEGIN { if (s < 90) printf "%d s", s; else printf "%.0f min", s / 60 }'; }
seconds_since() { awk -v a="$1" -v b="$(date +%s.%N)" 'BEGIN { printf "%.1f", b - a }'; }

mkdir -p "$out" || stop "cannot make the folder $out"
[ -w "$out" ] || stop "cannot write to the folder $out"
out=$(cd "$out" && pwd)
[ -w "$root" ] || stop "cannot write to $root, where the build goes; copy the clone to a folder of your own"
program=$root/build/release/raylex
cores=$(nproc)
begun=$(date +%s.%N)

# A hash of everything that a result depends on: the program, the job and the scene's files.
stamp_of() { find "$program" "$here/quickstart/$1.toml" "$here/scenes/$1" -type f -print0 | sort -z | xargs -0 sha256sum | awk '{ print $1 }' | sha256sum | awk '{ print $1 }'; }
study_stamp() { for scene in cornell-color mis-plates; do find "$program" "$here/studies/quickstart.toml" "$here/scenes/$scene" -type f -print0; done | sort -zu | xargs -0 sha256sum | awk '{ print $1 }' | sha256sum | awk '{ print $1 }'; }
is_studied() { [ -x "$program" ] && [ "$(cat "$out/study.stamp" 2>/dev/null)" = "$(study_stamp)" ] && [ -f "$out/study/report.html" ]; }
is_rendered() { [ -x "$program" ] && [ "$(cat "$out/$1.stamp" 2>/dev/null)" = "$(stamp_of "$1")" ] && [ -f "$out/$1.exr" ] && [ -f "$out/$1.png" ] && [ -f "$out/$1.noisy.png" ] && [ -f "$out/$1.json" ]; }

free_megabytes=$(df -Pm "$out" | awk 'NR == 2 { print $4 }')
[ -x "$program" ] || [ "${free_megabytes:-$needed_megabytes}" -ge "$needed_megabytes" ] ||
    stop "only $free_megabytes MB are free where $out is; about $needed_megabytes MB are needed"
bash "$here/install_packages.sh" || exit 2

# --- estimate -------------------------------------------------------------------------------------------------
probe() {
    local started core
    started=$(date +%s.%N)
    for ((core = 0; core < cores; core++)); do
        (cd "$root" && c++ -std=c++20 -O2 -I. -c lpe/language/glob.cpp -o /dev/null) &
    done
    wait
    awk -v s="$(seconds_since "$started")" -v p="$probe_seconds" 'BEGIN { printf "%d", 100 * s / p }'
}
pending=0
for scene in "${scenes[@]}"; do is_rendered "$scene" || pending=$((pending + 1)); done
if [ $pending -gt 0 ] || ! is_studied; then
    say "raylex quickstart on $cores cores. A probe estimates the times on this machine, as busy as it is now:"
    percent=$(probe)
    estimate() { say "  $1: about $(minutes $(($2 * percent / 100 / cores)))"; }
    [ -x "$program" ] || estimate "build what renders, for a coarse picture" $first_core_seconds
    [ -x "$program" ] || estimate "build the rest, while the picture is refined" $rest_core_seconds
    rendering=$((render_core_seconds * pending / ${#scenes[@]}))
    [ $pending -eq 0 ] || estimate "render $pending of ${#scenes[@]} scenes" $rendering
    is_studied || estimate "a study" $study_core_seconds
    say "About $needed_megabytes MB of disk are used."
fi
say "Results go to $out"

# --- build --------------------------------------------------------------------------------------------------------------
started=$(date +%s.%N)
# A build folder that was configured elsewhere (a moved or copied clone) cannot be used and must not be deleted.
cache=$root/build/release/CMakeCache.txt
if [ -f "$cache" ] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$cache"; then
    stop "build/release was configured for another folder; move it away (mv build/release build/release-old) and start again"
fi
if [ ! -f "$cache" ]; then
    say "Configuring ..."
    log=$(mktemp)
    if ! (cd "$root" && cmake --preset release) >"$log" 2>&1; then
        tail -n 30 "$log" >&2
        rm -f "$log"
        stop "configuring failed"
    fi
    rm -f "$log"
fi
# Ninja redraws one line on a terminal; elsewhere a line every 20 steps is enough.
build() {
    say "Building $1 ..."
    if [ -t 1 ]; then
        (cd "$root" && cmake --build --preset release --target "$2") || stop "the build failed"
    else
        (cd "$root" && cmake --build --preset release --target "$2") 2>&1 |
            awk '/^\[[0-9]+\/[0-9]+\]/ { split(substr($1, 2), step, /[\/\]]/); if (step[1] % 20 && step[1] != step[2]) next } { print; fflush() }' ||
            stop "the build failed"
    fi
}
if [ ! -x "$program" ]; then
    build "what renders" first_picture
    first=("$root/build/release/first_picture" "$here/scenes/${scenes[0]}/scene.pbrt" "$out/first.png")
    "${first[@]}" 8 || stop "the first picture failed"
    say "The first picture, still coarse, $(seconds_since "$begun") s after the start: $out/first.png"
    [ ! -t 1 ] || [ -z "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ] || xdg-open "$out/first.png" >/dev/null 2>&1 &
    nice "${first[@]}" 32 128 &
    refining=$!
fi
# The program and everything that `cmake --install` needs, but no tests.
build "the rest" raylex_installed
stop_refining
build_seconds=$(seconds_since "$started")

# --- render --------------------------------------------------------------------------------------------------------------
keep_earlier() {
    local file folder=""
    for file in "$@"; do
        [ -e "$file" ] || continue
        [ -n "$folder" ] || { folder=$(mktemp -d "$out/earlier-$(date +%Y%m%d-%H%M%S)-XXXX") || stop "cannot write to $out"; chmod 755 "$folder"; }
        mv "$file" "$folder/" || stop "cannot move $file to $folder"
    done
    [ -z "$folder" ] || say "Earlier results are kept in $folder"
}

failed=0 renders="" images=() made=()
for scene in "${scenes[@]}"; do
    base=$out/$scene
    stamp=$(stamp_of "$scene")
    started=$(date +%s.%N)
    if is_rendered "$scene"; then
        say "$scene: already rendered from these inputs"
        renders+=", $scene kept"
    else
        keep_earlier "$base.exr" "$base.png" "$base.noisy.png" "$base.json" "$base.stamp"
        say "Rendering $scene ..."
        "$program" render "$here/quickstart/$scene.toml" --spp 100 --denoise --keep-noisy -o "$base.exr" \
            --preview "$base.noisy.png" --stats "$base.json"
        status=$?
        [ $status -ne 130 ] || interrupted
        [ $status -le 1 ] || stop "rendering $scene failed"
        "$program" preview "$base.exr" -o "$base.png" || stop "the picture of $scene could not be made"
        printf '%s\n' "$stamp" >"$base.stamp"
        renders+=", $scene $(seconds_since "$started") s"
        made+=("$base.exr")
    fi
    images+=("$base.exr")
done

# --- verdict and page ----------------------------------------------------------------------------------------------------
say "Checking that the layers sum to beauty ..."
"$program" verify "${images[@]}"
status=$?
[ $status -le 1 ] || stop "the images could not be checked"
failed=$status
page=$out/index.html
[ ${#made[@]} -eq 0 ] || keep_earlier "$page"
"$program" report "${images[@]}" -o "$page" || stop "the page could not be made"

# --- study --------------------------------------------------------------------------------------------------
study=$out/study config=$here/studies/quickstart.toml
started=$(date +%s.%N)
if is_studied; then
    say "study: already run from these inputs"
    renders+=", study kept"
else
    step=run
    # Resumes an interrupted study if nothing that it depends on has changed.
    if [ -f "$study/experiment.json" ] && [ "$(cat "$out/study.started" 2>/dev/null)" = "$(study_stamp)" ]; then step=resume; else keep_earlier "$study"; fi
    study_stamp >"$out/study.started"
    say "Running a study of accuracy against time ..."
    "$program" experiment "$step" "$config" -o "$study"
    status=$?
    [ $status -ne 130 ] || interrupted
    [ $status -le 1 ] || stop "the study failed"
    [ $status -eq 0 ] || failed=1
    "$program" experiment report "$config" -o "$study" || stop "the study's report could not be made"
    study_stamp >"$out/study.stamp"
    renders+=", study $(seconds_since "$started") s"
fi

say ""
if [ "$failed" -eq 0 ]; then say "VERDICT: every split sums to its beauty, pixel by pixel."; else say "VERDICT: a split does NOT sum to its beauty; see above."; fi
say "Times: build $build_seconds s$renders."
say "Made:"
for scene in "${scenes[@]}"; do
    say "  $out/$scene.exr    beauty, layers and geometry in one multi-part OpenEXR"
    say "  $out/$scene.png    the denoised beauty through the display's view; $scene.noisy.png: before denoising"
done
say "  $page    every layer side by side"
say "  $study/report.html    error against time, with intervals; its images and tables beside it"
say ""
r=$(printf '%q' "$program") e=$(printf '%q' "$here")
say "Three things to try next:"
say "  $r render $e/scenes/mis-plates/scene.pbrt -o plates.exr --lpe mirrored='C<RS>L' --spp 32 && $r verify plates.exr"
say "  $r lpe explain 'C<RD>[DS]*<L.'\''key'\''>'"
say "  $r scene info $e/scenes/${scenes[0]}/scene.pbrt"
say "The tutorial of thirty minutes goes on from here: $here/docs/tutorial.md"
exit "$failed"
