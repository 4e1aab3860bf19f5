#!/usr/bin/env bash
# Builds and tests raylex in a Debian 13 of its own: makes a chroot by debootstrap from the package mirror of this
# machine's apt, installs the packages there, runs the short tests with warnings as errors, then the quickstart, and
# installs raylex's packages in a second Debian 13.
#
#   bash tests/debian13.sh [COMPILER...]     default g++; clang++ has a build folder of its own
#
# The chroot stays in build/debian13, so later runs build only what changed; `rm -r build/debian13` removes it. Needs
# Debian, root, and 2 GB of disk for the system and for the build of each compiler. Belongs to tests/run.sh --full.
# Prints "N passed, N failed, N skipped" at the end; exit code 1 if anything failed, 2 if something is missing.
set -uo pipefail
root=$(dirname "$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)")
system=$root/build/debian13
stop() { echo "debian13.sh: $*" >&2; exit 2; }
case "${1:-}" in
    -h | --help) sed -n '2,10s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
esac
[ $# -gt 0 ] || set -- g++
for compiler in "$@"; do
    case $compiler in g++ | clang++) ;; *) stop "unknown compiler '$compiler'; expected g++ or clang++" ;; esac
done
. "$root/tests/support/debian_system.sh"
[ -z "$(why_no_debian)" ] || stop "$(why_no_debian)"

# inside COMPILER COMMAND: each compiler has a build folder of its own.
inside() { built=$system/built/$1 in_debian "$system" "$2" CI=true CXX="$1"; }

if [ ! -e "$system/complete" ]; then
    echo "Making a Debian 13 in $system ..."
    make_debian trixie "$system" || exit 2
    touch "$system/complete"
fi

passed=0 failed=0 skipped=0
for compiler in "$@"; do
    printf '\n== Debian 13, %s: the short tests\n' "$compiler"
    started=$SECONDS
    log=$system.$compiler.log
    inside "$compiler" "bash experiments/install_packages.sh clang && bash tests/run.sh" >"$log" 2>&1
    status=$?
    counts=$(tail -n 1 "$log" | grep -E '^[0-9]+ passed, [0-9]+ failed, [0-9]+ skipped$') ||
        counts="0 passed, 1 failed, 0 skipped"
    read -r ok _ bad _ left_out _ <<<"$counts"
    passed=$((passed + ok)) failed=$((failed + bad)) skipped=$((skipped + left_out))
    [ "$status" -eq 0 ] || tail -n 60 "$log"
    echo "$counts, in $((SECONDS - started)) s ($compiler)"
done

printf '\n== Debian 13: the quickstart\n'
if inside "$1" "bash experiments/quickstart.sh" >"$system.quickstart.log" 2>&1; then
    passed=$((passed + 1))
    grep '^Times:' "$system.quickstart.log"
else
    failed=$((failed + 1))
    tail -n 30 "$system.quickstart.log"
fi

printf '\n== Debian 13: the packages\n'
log=$system.packages.log
if inside "$1" "bash experiments/install_packages.sh dpkg-dev file &&
        cmake --build --preset release --target raylex_installed &&
        cpack --config build/release/CPackConfig.cmake -B build/packages" >"$log" 2>&1; then
    bash tests/packages.sh "$system/built/$1/packages" trixie >"$log" 2>&1
fi
grep -E '^(FAILED|SKIPPED|measured)' "$log"
counts=$(tail -n 1 "$log" | grep -E '^[0-9]+ passed, [0-9]+ failed$') ||
    { tail -n 30 "$log"; counts="0 passed, 1 failed"; }
read -r ok _ bad _ <<<"$counts"
passed=$((passed + ok)) failed=$((failed + bad))
echo "$counts"
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ]
