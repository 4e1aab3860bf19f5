#!/usr/bin/env bash
# Builds raylex and runs its tests.
#
#   bash tests/run.sh                 the short run, for people: a Release build and its unit tests, in minutes
#   bash tests/run.sh --gate          what the short run leaves out: slow cases, plugins, Python, double precision, soak
#                                       and fuzz replay; unit tests under the address and undefined sanitizers; components
#                                       that build without any third-party library; a project outside that uses an
#                                       installed raylex; with CI=true also clang-format, clang-tidy and budgets of
#                                       instructions. CI runs the short run first, then --gate
#   bash tests/run.sh --full          the short run, the gate and the long half: statistical figures, reference images, exhaustive
#                                       comparison, fuzzing, notebooks, installing by pip, queues (GNU parallel,
#                                       Snakemake, Slurm), Debian 13 in a chroot
#   bash tests/run.sh NAME            only what matches, Release; builds only the programs that hold it. NAME is
#                                       a part: lpe, services, display, geoaovs, transport, experiments, stability,
#                                       cli, endtoend, python
#                                       a test file: tests/lpe/algebra/rest_test.cpp, rest_test, test_render.py
#                                       a tag: [law5]
#                                       words of a test case's name; * is a wildcard
#   bash tests/run.sh NAME --sanitize the same under the address and undefined sanitizers too
#   bash tests/run.sh --gate --release-only   skips the sanitizer build
#   bash tests/run.sh --benchmark lpe|exr|rays [GOOGLE BENCHMARK'S OPTIONS]   builds and runs one benchmark
#   bash tests/run.sh --instructions [--renew] [CASE...]   counts by valgrind what the inner loops of a Release build
#                                       execute, and compares with experiments/bench/instructions.toml
#   bash tests/run.sh --format [REVISION|all]   checks the lines changed since a revision (default main): at most 120
#                                       columns, no tabs, no blanks at the end; all: every source has the format of
#                                       clang-format 14
#   bash tests/run.sh --tidy [REVISION|FOLDER...|all]   runs clang-tidy 14, with the checks of .clang-tidy, over the
#                                       sources changed since a revision (default main), those of the folders, or all
#                                       sources except tests
#
# Prints "N passed, N failed, N skipped" at the end; exit 1 if anything failed, 2 for bad usage or a missing tool.
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(dirname "$here")
cd "$root" || exit 2

full=0 gate=0 sanitize=1 name=""
usage() { echo "tests/run.sh: $1; see tests/run.sh --help" >&2; exit 2; }

run_benchmark() {
    local program=bench_${1:-}
    [ -f "lpe/bench/$program.cpp" ] || [ -f "display/bench/$program.cpp" ] || [ -f "transport/bench/$program.cpp" ] ||
        usage "no benchmark '${1:-}'; expected lpe, exr or rays"
    shift
    bash experiments/install_packages.sh && cmake --preset bench >/dev/null || exit 2
    ninja -C build/bench -t query "$program" >/dev/null 2>&1 ||  # the list of targets has not those of subfolders
        usage "$program needs Google Benchmark (Debian: libbenchmark-dev)"
    cmake --build --preset bench --target "$program" || exit 2
    exec "build/bench/$program" "$@"
}

# Needs the Release build of the program, and makes it.
check_instructions() {
    bash experiments/install_packages.sh valgrind python3 || exit 2
    { cmake --preset release && cmake --build --preset release --target raylex; } >/dev/null || exit 2
    python3 experiments/bench/instructions.py "$@"
}

needs_tool() {
    command -v "$1" >/dev/null || usage "$1 is not installed (Debian: $1)"
}

# Raw strings in tests may be longer than a line: they are what another program reads.
check_format_of_all() {
    needs_tool clang-format-14
    git ls-files -z '*.cpp' '*.h' | xargs -0 clang-format-14 --dry-run 2>&1 |
        awk -F: '/warning: code should be clang-formatted/ { ++places[$1] }
                 END {
                     for (file in places) print file ": clang-format-14 writes " places[file] " places otherwise"
                     exit length(places) > 0
                 }'
}

# What is compiled stands in compile_commands.json: mostly the sources of one folder together, each as an #include.
check_tidy() {
    needs_tool clang-tidy-14
    local base wanted unit units=()
    if [ "$1" = all ]; then wanted=$(git ls-files lpe display geoaovs transport experiments)
    elif [ -d "$1" ]; then wanted=$(git ls-files "$@")
    else
        base=$(git merge-base "$1" HEAD 2>/dev/null) || usage "no revision and no folder '$1'"
        wanted=$(git diff --name-only --diff-filter=d "$base")
    fi
    wanted=$(grep '\.cpp$' <<<"$wanted") || { echo "no source to look at"; return 0; }
    # A folder of its own: clang-tidy does not know all warnings of g++, which CI makes errors.
    cmake --preset release -B build/tidy -DRAYLEX_WARNINGS_AS_ERRORS=OFF >/dev/null || exit 2
    while read -r unit; do
        if { echo "${unit#"$root"/}"; sed -n 's/^#include "\(.*\)"$/\1/p' "$unit"; } | grep -qxF -- "$wanted"; then
            units+=("$unit")
        fi
    done < <(sed -n 's/^ *"file": "\(.*\)",\{0,1\}$/\1/p' build/tidy/compile_commands.json)
    printf '%s\0' "${units[@]}" |
        xargs -0 -n 1 -P "$(nproc)" clang-tidy-14 -p build/tidy --quiet 2>/dev/null
}

# Changed lines of every kind of file; sources as a whole are check_format_of_all's.
check_format() {
    [ "$1" != all ] || { check_format_of_all; return; }
    local base
    base=$(git merge-base "$1" HEAD 2>/dev/null) || usage "no revision '$1' to compare with"
    git diff -U0 "$base" -- '*.cpp' '*.h' '*.sh' '*.cmake' '*CMakeLists.txt' '*.js' | LC_ALL=C.UTF-8 awk '
        /^\+\+\+ / { file = substr($0, 7); next }
        /^@@ / { split($3, at, ","); line = substr(at[1], 2); next }
        /^\+/ {
            text = substr($0, 2)
            if (length(text) > 120) { print file ":" line ": " length(text) " columns; expected at most 120"; bad = 1 }
            if (text ~ /\t/) { print file ":" line ": a tab; expected blanks"; bad = 1 }
            if (text ~ /[ \t]$/) { print file ":" line ": blanks at the end of the line"; bad = 1 }
            ++line
        }
        END { exit bad }'
}

while [ $# -gt 0 ]; do
    case $1 in
        --gate) gate=1 ;;
        --full) full=1 ;;
        --release-only) sanitize=0 ;;
        --sanitize) sanitize=2 ;;
        --benchmark) shift; run_benchmark "$@" ;;
        --instructions) shift; check_instructions "$@"; exit ;;
        --format) check_format "${2:-main}"; exit ;;
        --tidy) shift; check_tidy "${@:-main}"; exit ;;
        -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;;
        -*) usage "unknown option '$1'" ;;
        *) [ -z "$name" ] || usage "two names, '$name' and '$1'; expected at most one"; name=$1 ;;
    esac
    shift
done
[ -z "$name" ] || [ "$gate" = 0 ] || usage "--gate and '$name'; expected one of them"
[ -n "$name" ] || [ "$full" = 0 ] || gate=1

# What a name stands for: the parts whose programs are built and run, and what these are asked to run of their cases.
parts=() cases=() python_tests="test_*.py"
choose() {
    local part stem=${name##*/}
    stem=${stem%.cpp}
    for part in lpe services display geoaovs transport experiments stability cli endtoend fuzz python; do
        [ "$name" = "$part" ] && { parts=("$part"); return; }
    done
    if [ -f "tests/python/${stem%.py}.py" ]; then
        parts=(python) python_tests="${stem%.py}.py"
        return
    fi
    local files
    files=$(ls tests/*/"$stem".cpp tests/*/*/"$stem".cpp 2>/dev/null | grep -F -- "${name%.cpp}.cpp")
    if [ -n "$files" ]; then
        cases=(--filenames-as-tags "[#$stem]~[.]")
    else
        local wanted=$name
        case $name in \[* | *\** | \"*) ;; *) wanted="*$name*" ;; esac
        # A pattern alone would also choose the hidden long half. Apart, for behind a name "~" is one of its letters.
        cases=("$wanted" "~[.]")
        case $name in *\[.*) cases=("$wanted") ;; esac
        # Which files hold it: the same pattern over what stands between TEST_CASE and its body, a line a case.
        local pattern
        pattern=$(sed -e 's/^"\(.*\)"$/\1/' -e 's/[].^$\\[]/\\&/g' -e 's/^\*//' -e 's/\*$//' -e 's/\*/.*/g' <<<"$name")
        files=$(awk '/^(TEMPLATE_)?TEST_CASE/ { text = ""; on = 1 }
                     on { text = text $0 }
                     on && /\{ *$/ { gsub(/" +"/, "", text); print FILENAME "\t" text; on = 0 }' \
                $(find tests/{lpe,services,display,geoaovs,transport,experiments,stability,cli,endtoend,fuzz} -name '*.cpp') |
                grep -iE -- $'\t'".*$pattern" | cut -f1)
    fi
    [ -n "$files" ] || usage "'$name' is no part, no test file, and no test case has it in its name or tags"
    mapfile -t parts < <(cut -d/ -f2 <<<"$files" | sort -u)
}
[ -z "$name" ] || choose
# Only the gate sanitizes everything; a name does if --sanitize is given.
[ "$gate" = 1 ] || [ "$sanitize" != 1 ] || sanitize=0
[ -n "$name" ] && [ "$sanitize" = 1 ] && sanitize=0

bash "$root/experiments/install_packages.sh" || exit 2
# Tests of pages run them in a browser; a test of drawings runs Graphviz.
[ "$gate" = 0 ] || bash "$root/experiments/install_packages.sh" chromium graphviz || exit 2
# What the notebooks use beside the module, and queues; without them their tests are skipped, and those of frames and
# plots.
if [ "$full" = 1 ]; then
    bash "$root/experiments/install_packages.sh" python3-pandas python3-matplotlib python3-xarray jupyter-nbconvert \
        python3-ipykernel python3-pip python3-venv python3-setuptools python3-wheel \
        parallel make snakemake slurm-wlm munge || exit 2
fi

results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
passed=0 failed=0 skipped=0
failures=()

say() { printf '\n== %s (%s s)\n' "$1" "$SECONDS"; }
fail() { failed=$((failed + 1)); failures+=("$1"); echo "FAILED: $1"; }

# configure_and_build <preset> [cmake arguments]: the programs of the chosen parts, or all targets. Prints only errors.
configure_and_build() {
    local preset=$1
    shift
    say "Building preset '$preset'${parts[*]:+: ${parts[*]/#/test_}}"
    local log="$results/build-$preset.log"
    local cache=build/$preset/CMakeCache.txt
    if [ -f "$cache" ] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$cache"; then
        fail "build/$preset was configured for another folder; move it away: mv build/$preset build/$preset-old"
        return 1
    fi
    local targets=()
    [ ${#parts[@]} = 0 ] || targets=(--target "${parts[@]/#/test_}")
    # Plugins that only the gate's cases load.
    [ -z "$name" ] && [ "$sanitize" != 2 ] || [[ " ${parts[*]} " != *" experiments "* && " ${parts[*]} " != *" cli "* ]] ||
        targets+=(test_plugins)
    if ! { cmake --preset "$preset" "$@" && cmake --build --preset "$preset" "${targets[@]}"; } >"$log" 2>&1; then
        grep -E -B2 -A12 'error|FAILED|Error' "$log" | head -n 60
        tail -n 20 "$log"
        fail "build of preset '$preset'"
        return 1
    fi
}

# beside NAME COMMAND...: goes on while the command does, in a shell of its own; collect NAME waits for it, and prints and
# counts what it did.
beside() {
    local name=$1
    shift
    {
        passed=0 failed=0 skipped=0 failures=()
        "$@" >"$results/$name.said" 2>&1
        { echo "$passed $failed $skipped"; printf '%s\n' "${failures[@]}"; } >"$results/$name.counting"
        mv "$results/$name.counting" "$results/$name.counts"
    } &
}
collect() {
    local name=$1 more
    while [ ! -e "$results/$name.counts" ] && [ -n "$(jobs -rp)" ]; do wait -n; done
    cat "$results/$name.said"
    if ! read -ra more <"$results/$name.counts"; then fail "$name ended before its report was complete"; return; fi
    passed=$((passed + more[0])) failed=$((failed + more[1])) skipped=$((skipped + more[2]))
    mapfile -t more < <(sed -e 1d -e '/^$/d' "$results/$name.counts")
    failures+=("${more[@]}")
}

# The programs of a build, those that take longest first: so that all cores have something to do to the end.
programs_of() {
    local name
    for name in transport experiments cli lpe endtoend display; do ls "build/$1/test_$name" 2>/dev/null; done
    ls "build/$1"/test_* 2>/dev/null | grep -vE '/test_(transport|experiments|cli|lpe|endtoend|display)$'
}

# run_programs <preset> <label> <catch arguments...>: every test program of the build, as many at once as there are cores;
# with counts from Catch2's own report.
run_programs() {
    local preset=$1 label=$2
    shift 2
    local program name report log cases ok bad status ran=0 programs=()
    for program in $(programs_of "$preset"); do
        [ -x "$program" ] || continue
        [ ${#parts[@]} = 0 ] || [[ " ${parts[*]} " == *" ${program##*/test_} "* ]] || continue
        programs+=("$program")
    done
    for program in "${programs[@]}"; do
        report="$results/$preset-$label-$(basename "$program")"
        while [ "$(jobs -rp | wc -l)" -ge "$(nproc)" ]; do wait -n; done
        {
            TIMEFORMAT='%0U'
            { time "$program" -r xml -o "$report.xml" "$@" >"$report.log" 2>&1; } 2>"$report.seconds"
            echo $? >"$report.status"
        } &
    done
    wait
    for program in "${programs[@]}"; do
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
        ran=$((ran + ok + bad))
        # Catch2 moves standard output into its report.
        left_out=$(grep -c '^SKIPPED ' "$report")
        grep '^SKIPPED ' "$report"
        passed=$((passed + ok - left_out))
        skipped=$((skipped + left_out))
        printf '%-22s %-10s %4d passed %4d failed %4d skipped %5s CPU s\n' "$name" "$label" "$((ok - left_out))" \
            "$bad" "$left_out" "$(cat "$results/$preset-$label-$name.seconds")"
        if [ "$bad" -gt 0 ] || { [ "$status" -ne 0 ] && [ "$ok" -gt 0 ]; }; then
            # As text, of this run: what failed once need not fail again.
            local told
            told=$(python3 "$here/support/failed_cases.py" "$report")
            printf '%s\n' "$told"
            tail -n 60 "$log"
            failed=$((failed + (bad > 0 ? bad : 1)))
            failures+=("$name ($label)${told:+$'\n'$told}")
        fi
    done
    # The tests of Python alone have no program.
    [ "$ran" -gt 0 ] || [ "${parts[*]}" = python ] || fail "no test case ran ($label); expected some"
}

# run_python: the tests of the Python module, with unittest's own counts.
run_python() {
    [ ${#parts[@]} = 0 ] || [[ " ${parts[*]} " == *" python "* ]] || return 0
    say "Python"
    local log="$results/python.log" ran bad left_out
    PYTHONPATH=build/release/python PYTHONDONTWRITEBYTECODE=1 RAYLEX_FULL=$full \
        RAYLEX_BUILD="$root/build/release" RAYLEX_PROGRAM="$root/build/release/raylex" \
        /usr/bin/python3 -m unittest discover -v -s tests/python -p "$python_tests" >"$log" 2>&1
    local status=$?
    ran=$(sed -n 's/^Ran \([0-9]*\) tests\{0,1\} in .*/\1/p' "$log" | tail -n 1)
    if [ -z "$ran" ] || [ "$ran" = 0 ]; then
        tail -n 40 "$log"
        fail "the Python module's tests (status $status)"
        return
    fi
    left_out=$(tail -n 1 "$log" | sed -n 's/.*skipped=\([0-9]*\).*/\1/p')
    bad=$(tail -n 1 "$log" | grep -oE '(failures|errors)=[0-9]+' | cut -d= -f2 | awk '{ sum += $1 } END { print sum }')
    left_out=${left_out:-0} bad=${bad:-0}
    grep -oE '^[^ ]+ .* skipped .*' "$log" | sed 's/^/SKIPPED /'
    passed=$((passed + ran - left_out - bad))
    skipped=$((skipped + left_out))
    printf '%-22s %-10s %4d passed %4d failed %4d skipped\n' \
        python release "$((ran - left_out - bad))" "$bad" "$left_out"
    [ "$status" -eq 0 ] && return
    sed -n '/^=====/,$p' "$log" | head -n 80
    failed=$((failed + (bad > 0 ? bad : 1)))
    failures+=("python")
}

# run_slurm: a study on a Slurm of its own.
run_slurm() {
    say "Slurm"
    local log="$results/slurm.log" counts
    bash tests/cluster/slurm.sh build/release/raylex >"$log" 2>&1
    local status=$?
    grep -E '^(SKIPPED|FAILED|measured)' "$log"
    counts=$(tail -n 1 "$log" | grep -oE '^[0-9]+ passed, [0-9]+ failed$')
    if grep -q '^SKIPPED' "$log"; then
        skipped=$((skipped + 1))
    elif [ -z "$counts" ]; then
        tail -n 40 "$log"
        fail "the study on Slurm (status $status)"
    else
        passed=$((passed + ${counts%% *}))
        [ "$status" -eq 0 ] || fail "the study on Slurm: $counts"
    fi
}

# run_packages: the Debian packages, installed in a system of their own.
run_packages() {
    say "Packages"
    local log="$results/packages.log" counts
    bash tests/packages.sh build/release >"$log" 2>&1
    counts=$(tail -n 1 "$log" | grep -oE '^[0-9]+ passed, [0-9]+ failed$')
    grep -E '^(SKIPPED|measured)' "$log"
    if grep -q '^SKIPPED' "$log"; then
        skipped=$((skipped + 1))
    elif [ -z "$counts" ]; then
        tail -n 40 "$log"
        fail "the packages"
    else
        passed=$((passed + ${counts%% *}))
        case $counts in *" 0 failed") ;; *) grep -A30 '^FAILED' "$log"; fail "the packages: $counts" ;; esac
    fi
}

# In CI on Debian 12 alone, which has these tools: 34 MB of packages. clang-tidy takes the folders where a mistake costs
# most.
check_sources() {
    bash experiments/install_packages.sh clang-format-14 clang-tidy-14 || exit 2
    say "Sources as clang-format 14 writes them"
    if check_format_of_all; then passed=$((passed + 1)); else fail "the format of sources"; fi
    say "clang-tidy 14 over lpe, transport/paths and transport/integrators"
    if check_tidy lpe transport/paths transport/integrators; then passed=$((passed + 1)); else fail "clang-tidy"; fi
}
is_debian_12() { grep -qs '^VERSION_CODENAME=bookworm' /etc/os-release; }
if [ "${CI:-}" = "true" ] && [ "$gate" = 1 ]; then
    if is_debian_12; then
        check_sources
    else
        echo "SKIPPED the format of sources, clang-tidy and budgets of instructions: they are those of Debian 12's tools"
        skipped=$((skipped + 1))
    fi
fi

warnings=()
[ "${CI:-}" = "true" ] && warnings=(-DRAYLEX_WARNINGS_AS_ERRORS=ON)

# The short run builds the unit tests without plugins, Python and double precision, and leaves out slow cases, which
# carry the tag [gate].
short_parts=(transport experiments cli lpe services display geoaovs endtoend)
selection=("${cases[@]}")
if [ -z "$name" ]; then
    if [ "$full" = 1 ]; then selection=("~[.]"); elif [ "$gate" = 1 ]; then selection=("[gate]~[.]"); else parts=("${short_parts[@]}") selection=("~[gate]~[.]"); fi
fi

# Programs that the short run does not build.
run_rest_of_release() {
    local parts=(transport_double stability soak fuzz)
    run_programs release release
}

if configure_and_build release "${warnings[@]}"; then
    say "Release tests"
    if [ "$gate" = 1 ]; then
        beside python run_python
        parts=("${short_parts[@]}")
        run_programs release gate "${selection[@]}"
        run_rest_of_release
        parts=()
        collect python
    else
        [[ " ${parts[*]} " != *" python "* ]] || run_python
        run_programs release release "${selection[@]}"
    fi
    if [ "$full" = 1 ]; then
        say "Long tests (Release)"
        run_programs release full "[.full]"
        [ -n "$name" ] || run_slurm
        [ -n "$name" ] || run_packages
    fi
fi

# Counts are the same whatever else runs.
count_instructions() {
    say "Instructions of the inner loops"
    if check_instructions; then passed=$((passed + 1)); else fail "an inner loop is dearer than its budget"; fi
}
counts_instructions=0
if [ "${CI:-}" = "true" ] && [ "$gate" = 1 ] && is_debian_12; then
    counts_instructions=1
    beside instructions count_instructions
fi

# Whole renders have no sanitizer build: transport's own tests take the same code through it.
if [ "$sanitize" = 2 ] && [ -n "$name" ]; then
    kept=()
    for part in "${parts[@]}"; do [ "$part" = endtoend ] || [ "$part" = python ] || kept+=("$part"); done
    parts=("${kept[@]}")
    [ ${#parts[@]} -gt 0 ] || sanitize=0
fi
if [ "$sanitize" != 0 ] && configure_and_build asan "${warnings[@]}"; then
    say "Unit tests under the address and undefined sanitizers"
    # Embree's and TBB's own allocations live until exit; leaks of ours are still reported by type.
    export ASAN_OPTIONS=${ASAN_OPTIONS:-detect_leaks=1:abort_on_error=0}
    export LSAN_OPTIONS="${LSAN_OPTIONS:-suppressions='$here/support/lsan.supp':print_suppressions=0}"
    export UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1}
    if [ ${#cases[@]} = 0 ]; then
        run_programs asan sanitized "~[statistical]~[release-only]~[.]"
    else
        run_programs asan sanitized "${cases[@]:0:${#cases[@]}-1}" "${cases[-1]}~[statistical]~[release-only]"
    fi
fi

[ "$counts_instructions" = 0 ] || collect instructions

# Each fuzz target from its corpus for a minute: a crash, a hang, a sanitizer's finding or 256 MiB in use fails it.
fuzz_seconds=60
run_fuzzers() {
    local runtime
    if ! runtime=$(clang++-14 -print-file-name="libclang_rt.fuzzer-$(uname -m).a" 2>/dev/null) || [ ! -e "$runtime" ]; then
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
# The short tests by both compilers, and the quickstart.
run_debian13() {
    say "Debian 13"
    local why
    why=$(. tests/support/debian_system.sh && why_no_debian)
    if [ -n "$why" ]; then
        echo "SKIPPED Debian 13: $why"
        skipped=$((skipped + 1))
    elif bash tests/debian13.sh g++ clang++; then passed=$((passed + 1)); else fail "Debian 13"; fi
}
if [ "$full" = 1 ] && [ "$gate" = 1 ]; then
    run_fuzzers
    run_debian13
fi

# Sources are compiled many together: each must include what it uses all the same. --full sees to all of them.
compiles_alone() {
    say "Each source of lpe and services by itself"
    if find lpe display/{services,buffer,deep,filters} -name '*.cpp' -not -path '*/bench/*' -print0 |
        xargs -0 -n 4 -P "$(nproc)" "${CXX:-c++}" -std=c++20 -fsyntax-only -I. >"$results/alone.log" 2>&1; then
        passed=$((passed + 1))
    else
        head -n 40 "$results/alone.log"
        fail "a source does not compile by itself"
    fi
    if [ "$full" = 1 ] && configure_and_build apart "${warnings[@]}"; then passed=$((passed + 1)); fi
}

if [ "$gate" = 1 ]; then
    compiles_alone
    if configure_and_build adopters "${warnings[@]}"; then
        say "Components lpe, services and geoaovs without any third-party library"
        run_programs adopters adopters
    fi
    say "A project outside, on an installed raylex"
    for wanted in "lpe;services;geoaovs" "lpe;services;display;geoaovs;transport;plugin"; do
        preset=release
        [ "$wanted" = "lpe;services;geoaovs" ] && preset=adopters
        prefix="$results/prefix-$preset" build="$results/outside-$preset" log="$results/outside-$preset.log"
        hide=()
        [ "$preset" = adopters ] && hide=(-DCMAKE_DISABLE_FIND_PACKAGE_embree=ON -DCMAKE_DISABLE_FIND_PACKAGE_OpenEXR=ON
            -DCMAKE_DISABLE_FIND_PACKAGE_OpenColorIO=ON -DCMAKE_DISABLE_FIND_PACKAGE_TBB=ON)
        # Installing builds what is missing, as where only the program was built.
        rm -f "build/$preset/lpe/libraylex_lpe.a" "build/$preset/plugins/libplanted_error.so"
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

# The parts that another renderer adopts, cross-compiled and run in an emulator.
run_arm64() {
    say "arm64"
    local ok=0 bad=1 left_out=0
    bash tests/arm64.sh | tee "$results/arm64.log"
    read -r ok _ bad _ left_out _ < <(tail -n 1 "$results/arm64.log")
    passed=$((passed + ok)) skipped=$((skipped + left_out))
    [ "$bad" = 0 ] || fail "arm64"
}
if [ "$full" = 1 ] && [ "$gate" = 1 ]; then run_arm64; fi

say "Summary"
for each in "${failures[@]}"; do echo "FAILED: $each"; done
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
