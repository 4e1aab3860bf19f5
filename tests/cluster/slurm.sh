#!/usr/bin/env bash
# A study on a real Slurm, on this one machine: the bits of the local runner, whatever happens to tasks, and the time
# beside it. Needs root and the packages slurm-wlm and munge; belongs to tests/run.sh --full.
#
#   bash tests/cluster/slurm.sh [RAYLEX] [--cells N] [--kills N]
#
# Prints what it measured; ends with "N passed, N failed".
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(dirname "$(dirname "$here")")
raylex=$root/build/release/raylex cells=200 kills=20
while [ $# -gt 0 ]; do
    case $1 in
        --cells) cells=$2; shift ;;
        --kills) kills=$2; shift ;;
        *) raylex=$(realpath "$1") ;;
    esac
    shift
done
source "$here/local_slurm.sh"
if lacks=$(slurm_lacks) && [ -n "$lacks" ]; then
    echo "SKIPPED the study on Slurm: $lacks"
    exit 0
fi

folder=$(mktemp -d)
full=""
cleanup() {
    end_slurm
    [ -z "$full" ] || umount "$full" 2>/dev/null
    rm -rf "$folder"
}
trap cleanup EXIT
passed=0 failed=0
check() {  # check WHAT COMMAND...
    local what=$1
    shift
    if "$@"; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAILED: $what"; fi
}
says() { grep -qF -- "$2" <<<"$1" || { echo "expected '$2' in: $1"; return 1; }; }
seconds() { date +%s.%N; }
since() { awk -v a="$1" -v b="$(seconds)" 'BEGIN { printf "%.1f", b - a }'; }

# Every number of every cell: what the sums, arrays and counts of a cell are, whoever rendered it.
bits() {
    (cd "$1/cells" && find . -name 'record.bin' -o -name '*.npy' | sort | xargs sha256sum | sha256sum)
}

cat >"$folder/study.toml" <<END
name = "slurm"
replicates = $((cells / 2))
threads = 2
[[scene]]
name = "box"
file = "$root/experiments/scenes/cornell-grey/scene.pbrt"
resolution = [64, 64]
[[method]]
name = "path"
[[method]]
name = "shallow"
integrator = { type = "path" }
max_depth = 3
[budget]
samples = ${SPP:-256}
[reference]
method = "path"
spp = 256
[[channel]]
name = "direct"
lpe = "C<RD>L"
END
cd "$folder" || exit 2
begin_slurm "$folder/slurm" 2 || { tail -n 20 "$folder"/slurm/*.out "$folder"/slurm/*.log; echo "0 passed, 1 failed"; exit 1; }

all_done() { [ -z "$(squeue -h)" ]; }
submit() { "$raylex" submit --slurm "${study:-study.toml}" -o "$1" --shards 8 --no-report "${@:2}" 2>&1; }

# As it goes, beside the local runner.
start=$(seconds)
"$raylex" experiment run "$folder/study.toml" -o local >local.log 2>&1 || { tail local.log; exit 1; }
local_seconds=$(since "$start")
start=$(seconds)
said=$(submit calm)
check "a study is submitted" says "$said" "8 of 8 shards submitted"
check "a second submit is refused" says "$(submit calm)" "a study was submitted into this directory"
check "--again is refused while its jobs are there" says "$(submit calm --again)" "still in the queue"
"$raylex" status calm >/dev/null
check "status says that it is not done" test $? = 1
# Asking the queue costs the cores time that tasks would have, so what the merge leaves is waited for.
wait_for 1800 test -e calm/results/experiment.json
slurm_seconds=$(since "$start")
wait_for 60 all_done
echo "measured: $cells cells, local $local_seconds s, 8 Slurm tasks on 2 cores $slurm_seconds s from submit to merged" \
    "($(uptime | sed 's/.*load/load/'))"
said=$("$raylex" status calm)
check "status says that it is done" test $? = 0
check "all tasks are done" says "$said" "10 done"
check "the bits are those of the local runner" test "$(bits local)" = "$(bits calm/results)"
check "cells name their processor" grep -q '"machine"' calm/results/cells/box.path*.r0/cell.json

# Tasks are killed, requeued and cancelled while they run, again and again, which should hit cells with checkpoints.
{ echo 'checkpoint = "0.2s"'; cat study.toml; } >often.toml
study=often.toml
submit wild >/dev/null
job=$(sed -n 's/.*"shards": "\([0-9]*\)".*/\1/p' wild/submission.json)
done_kills=0
for ((try = 0; done_kills < kills && try < 40 * kills; ++try)); do
    sleep "0.$((RANDOM % 9 + 1))"
    task=$(squeue -h --array --states=RUNNING --jobs="$job" --format=%i 2>/dev/null | shuf -n 1)
    if [ -z "$task" ]; then
        all_done && { submit wild --again >/dev/null
            job=$(sed -n 's/.*"shards": "\([0-9]*\)".*/\1/p' wild/submission.json); }
        continue
    fi
    case $((done_kills % 3)) in
        0) scontrol requeue "$task" ;;
        1) scancel --signal=KILL --full "$task" ;;
        2) kill -9 "$(pgrep -f "experiment run.*-o $folder/wild/parts/${task##*_} " | shuf -n 1)" ;;
    esac 2>/dev/null && done_kills=$((done_kills + 1))
done
wait_for 1800 all_done
for _ in 1 2 3; do
    "$raylex" status wild >status.log && break
    submit wild --again >/dev/null
    wait_for 1800 all_done
done
echo "measured: $done_kills kills of tasks (requeue, signal KILL to the whole task, kill -9 of one process)"
check "as many kills as asked for" test "$done_kills" -ge "$kills"
check "after kills all is done" "$raylex" status wild
check "after kills the bits are the same" test "$(bits local)" = "$(bits wild/results)"

# A full disk under one task: that task fails, the others go on, and submitting again ends in the same bits.
full=$folder/full/parts/3
mkdir -p "$full" && mount -t tmpfs -o size=300k tmpfs "$full" && {
    submit full >/dev/null
    wait_for 1800 all_done
    said=$("$raylex" status full)
    check "a full disk is a failure of that task" says "$said" "shard 3: FAILED"
    check "the others are done" test "$(grep -c '^shard [0-9]*: done' <<<"$said")" = 7
    mount -o remount,size=500m "$full"
    submit full --again >/dev/null
    wait_for 1800 all_done
    check "submitted again all is done" "$raylex" status full
    check "after a full disk the bits are the same" test "$(bits local)" = "$(bits full/results)"
}

echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
