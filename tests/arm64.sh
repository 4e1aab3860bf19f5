#!/usr/bin/env bash
# Compiles raylex for arm64 and runs the tests of lpe, services and display there, in an emulator (qemu-user). Makes a
# Debian 12 of its own: a chroot by debootstrap from the package mirror of this machine's apt, with Debian's cross
# compiler and libraries of arm64. transport is compiled and linked; its tests are run if they are named.
#
#   bash tests/arm64.sh [PART...]      default lpe services display
#
# The chroot stays in build/arm64, so later runs build only what changed; `rm -r build/arm64` removes it. Needs Debian,
# root, 3 GB of disk and 40 minutes on two cores for the first run. Belongs to tests/run.sh --full.
# Prints "N passed, N failed, N skipped" at the end, and why where it skips; exit code 1 if anything failed.
set -uo pipefail
root=$(dirname "$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)")
system=$root/build/arm64
skip() { echo "SKIPPED arm64: $*"; echo "0 passed, 0 failed, 1 skipped"; exit 0; }
case "${1:-}" in
    -h | --help) sed -n '2,11s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
esac
[ $# -gt 0 ] || set -- lpe services display
[ "$(dpkg --print-architecture 2>/dev/null)" = amd64 ] || skip "it needs Debian on amd64, to cross-compile"
. "$root/tests/support/debian_system.sh"
[ -z "$(why_no_debian)" ] || skip "$(why_no_debian)"

built=$system/built
inside() { in_debian "$system" "$1"; }

if [ ! -e "$system/complete" ]; then
    echo "Making a Debian 12 with a compiler for arm64 in $system ..."
    make_debian bookworm "$system" || skip "the chroot could not be made"
    # The libraries that transport and the parts below it link.
    libraries=$(sed -n '/^libembree-dev/s/\([^ ]*-dev\)/\1:arm64/gp' "$root/experiments/packages.txt")
    if ! inside "dpkg --add-architecture arm64 && apt-get update && apt-get install -y --no-install-recommends \
            g++-aarch64-linux-gnu cmake ninja-build ccache git qemu-user-static catch2 $libraries" >"$system.log" 2>&1; then
        tail -n 20 "$system.log"
        skip "the packages could not be installed; the messages are in $system.log"
    fi
    touch "$system/complete"
fi

passed=0 failed=0
outcome() { if [ "$1" = 0 ]; then passed=$((passed + 1)); else failed=$((failed + 1)); fi; }

printf '\n== arm64: compiling and linking\n'
started=$SECONDS
# -O1, because optimisation takes longer than the emulator saves by it.
inside "cmake --preset release '-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG' -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 \
    -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++ -DRAYLEX_WARNINGS_AS_ERRORS=ON \
    '-DRAYLEX_COMPONENTS=lpe;services;display;geoaovs;transport' &&
    nice -n 15 cmake --build --preset release --target measure_in_float ${*/#/test_}" >"$system.build.log" 2>&1
status=$?
outcome "$status"
[ "$status" = 0 ] || { grep -E -A12 'error|FAILED' "$system.build.log" || tail -n 20 "$system.build.log"; } | head -n 60
echo "compiled in $((SECONDS - started)) s"

for part in "$@"; do
    started=$SECONDS
    log=$system.$part.log
    inside "nice -n 15 qemu-aarch64-static build/release/test_$part '~[.]~[gate]'" >"$log" 2>&1
    status=$?
    summary=$(tail -n 3 "$log" | grep -E '^(All tests passed|test cases:)')
    [ "$status" != 0 ] && tail -n 60 "$log"
    [ -n "$summary" ] || { status=1 summary="ended before its report was complete"; }
    outcome "$status"
    echo "test_$part on arm64: $summary, in $((SECONDS - started)) s"
done
echo "$passed passed, $failed failed, 0 skipped"
[ "$failed" -eq 0 ]
