#!/usr/bin/env bash
# Builds and runs every test: Release, then the unit tests under the address and undefined sanitizers, then the
# components that build without any third-party library, then a project outside that uses an installed raylex.
#
#   bash tests/run.sh                 everything short
#   bash tests/run.sh FILTER          only test cases whose name or [tag] matches (Catch2's syntax, * is a wildcard)
#   bash tests/run.sh --full          adds the long half: statistical figures, reference images, exhaustive comparison, fuzzing
#   bash tests/run.sh --release-only  skips the sanitizer build
#
# Ends with "N passed, N failed, N skipped"; exit 1 if anything failed, 2 for bad usage or a missing tool.
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(dirname "$here")
cd "$root" || exit 2

full=0 sanitize=1 filter=""
for argument in "$@"; do
    case $argument in
        --full) full=1 ;;
        --release-only) sanitize=0 ;;
        -h | --help) sed -n '2,10s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
        -*) echo "tests/run.sh: unknown option '$argument'; expected --full, --release-only or a filter" >&2; exit 2 ;;
        *) filter=$argument ;;
    esac
done
case $filter in "" | \[* | *\** | \"*) ;; *) filter="*$filter*" ;; esac

bash "$root/experiments/install_packages.sh" || exit 2

results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
passed=0 failed=0 skipped=0
failures=()

say() { printf '\n== %s\n' "$1"; }
fail() { failed=$((failed + 1)); failures+=("$1"); echo "FAILED: $1"; }

# configure_and_build <preset> [cmake arguments]: quiet unless it fails.
configure_and_build() {
    local preset=$1
    shift
    say "Building preset '$preset'"
    local log="$results/build-$preset.log"
    if ! { cmake --preset "$preset" "$@" && cmake --build --preset "$preset"; } >"$log" 2>&1; then
        grep -E -B2 -A12 'error|FAILED|Error' "$log" | head -n 60
        tail -n 20 "$log"
        fail "build of preset '$preset'"
        return 1
    fi
}

# run_programs <preset> <label> <catch arguments...>: every test program of the build, as many at once as there are cores, with
# counts from Catch2's own report.
run_programs() {
    local preset=$1 label=$2
    shift 2
    local program name report log cases ok bad status
    for program in "build/$preset"/test_*; do
        [ -x "$program" ] || continue
        report="$results/$preset-$label-$(basename "$program")"
        while [ "$(jobs -rp | wc -l)" -ge "$(nproc)" ]; do wait -n; done
        { "$program" -r xml -o "$report.xml" "$@" >"$report.log" 2>&1; echo $? >"$report.status"; } &
    done
    wait
    for program in "build/$preset"/test_*; do
        [ -x "$program" ] || continue
        name=$(basename "$program")
        report="$results/$preset-$label-$name.xml" log="$results/$preset-$label-$name.log"
        status=$(cat "$results/$preset-$label-$name.status")
        cases=$(grep -o '<OverallResultsCases [^>]*>' "$report" 2>/dev/null | tail -n 1)
        ok=$(sed -n 's/.*successes="\([0-9]*\)".*/\1/p' <<<"$cases")
        bad=$(sed -n 's/.*failures="\([0-9]*\)".*/\1/p' <<<"$cases")
        if [ -z "$cases" ]; then
            tail -n 40 "$log"
            fail "$name ($label): ended with status $status before its report was complete"
            continue
        fi
        local left_out
        left_out=$(grep -c '^SKIPPED ' "$log")
        grep '^SKIPPED ' "$log"
        passed=$((passed + ok - left_out))
        skipped=$((skipped + left_out))
        printf '%-22s %-10s %4d passed %4d failed %4d skipped\n' "$name" "$label" "$((ok - left_out))" "$bad" "$left_out"
        if [ "$bad" -gt 0 ] || { [ "$status" -ne 0 ] && [ "$ok" -gt 0 ]; }; then
            # Once more for a reader: the failing assertions as text.
            "$program" "$@" 2>&1 | head -n 80
            failed=$((failed + (bad > 0 ? bad : 1)))
            failures+=("$name ($label)")
        fi
    done
}

warnings=()
[ "${CI:-}" = "true" ] && warnings=(-DRAYLEX_WARNINGS_AS_ERRORS=ON)
selection=()
[ -n "$filter" ] && selection=("$filter~[.]")   # a pattern alone would also choose the hidden long half

if configure_and_build release "${warnings[@]}"; then
    say "Release tests"
    run_programs release release "${selection[@]}"
    if [ "$full" = 1 ]; then
        say "Long tests (Release)"
        run_programs release full "[.full]"
    fi
fi

if [ "$sanitize" = 1 ] && configure_and_build asan "${warnings[@]}"; then
    say "Unit tests under the address and undefined sanitizers"
    # Embree's and TBB's own allocations live until exit; leaks of ours are still reported by type.
    export ASAN_OPTIONS=${ASAN_OPTIONS:-detect_leaks=1:abort_on_error=0}
    export LSAN_OPTIONS="${LSAN_OPTIONS:-suppressions='$here/support/lsan.supp':print_suppressions=0}"
    export UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1}
    run_programs asan sanitized "$filter~[statistical]~[release-only]~[.]"
fi

# Each fuzz target from its corpus for a minute: a crash, a hang, a sanitizer's finding or 256 MiB in use fails it.
fuzz_seconds=60
run_fuzzers() {
    local runtime
    if ! runtime=$(clang++-14 -print-file-name=libclang_rt.fuzzer-x86_64.a 2>/dev/null) || [ ! -e "$runtime" ]; then
        echo "SKIPPED fuzzing: needs the packages clang-14 and libclang-rt-14-dev"
        skipped=$((skipped + 1))
        return
    fi
    configure_and_build fuzz "${warnings[@]}" || return
    say "Fuzzing, $fuzz_seconds seconds a target"
    local program name target
    for program in build/fuzz/fuzz_*; do
        name=$(basename "$program") target=${program##*fuzz_}
        mkdir -p "build/fuzz/findings"
        bash tests/fuzz/corpus.sh unpack "$target" "$results/fuzz/$target"
        if "$program" -max_total_time=$fuzz_seconds -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 \
            -artifact_prefix="build/fuzz/findings/$target-" "$results/fuzz/$target" \
            >"$results/$name.log" 2>&1; then
            printf '%-22s %s inputs\n' "$name" "$(sed -n 's/^stat::number_of_executed_units: *//p' "$results/$name.log")"
            passed=$((passed + 1))
        else
            tail -n 40 "$results/$name.log"
            fail "$name (the input is kept in build/fuzz/findings)"
        fi
    done
}
if [ "$full" = 1 ] && [ -z "$filter" ]; then run_fuzzers; fi

if [ -z "$filter" ]; then
    if configure_and_build adopters "${warnings[@]}"; then
        say "Components lpe and services without any third-party library"
        run_programs adopters adopters
    fi
    say "A project outside, on an installed raylex"
    for wanted in "lpe;services" "lpe;services;display;geoaovs;transport;plugin"; do
        preset=release
        [ "$wanted" = "lpe;services" ] && preset=adopters
        prefix="$results/prefix-$preset" build="$results/outside-$preset" log="$results/outside-$preset.log"
        hide=()
        [ "$preset" = adopters ] && hide=(-DCMAKE_DISABLE_FIND_PACKAGE_embree=ON -DCMAKE_DISABLE_FIND_PACKAGE_OpenEXR=ON
            -DCMAKE_DISABLE_FIND_PACKAGE_OpenColorIO=ON -DCMAKE_DISABLE_FIND_PACKAGE_TBB=ON)
        if { cmake --install "build/$preset" --prefix "$prefix" &&
            cmake -G Ninja -S tests/outside -B "$build" "-DCMAKE_PREFIX_PATH=$prefix" "-DRAYLEX_WANTED=$wanted" "${hide[@]}" &&
            cmake --build "$build"; } >"$log" 2>&1; then
            for program in "$build"/outside_*; do
                if [ -x "$program" ] && [ -f "$program" ]; then
                    if (cd "$build" && "$program"); then passed=$((passed + 1)); else fail "outside project: $(basename "$program")"; fi
                fi
            done
        else
            tail -n 30 "$log"
            fail "outside project with components $wanted"
        fi
    done
fi

say "Summary"
for each in "${failures[@]}"; do echo "FAILED: $each"; done
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
