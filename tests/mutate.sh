#!/usr/bin/env bash
# Tests the tests: changes the lines of tests/mutations.txt one at a time, in a copy of the committed tree, and runs the
# unit tests of the services and of transport until one fails.
#
#   bash tests/mutate.sh [FIRST [LAST]]     mutations by number, from 1; default: all. A minute and a half each on two cores
#
# Prints for each mutation the test case that failed, or SURVIVED. Exit code 1 if any survived, 2 if one does not apply
# or compile.
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
git -C "$root" archive HEAD | tar -x -C "$work" || exit 2
cd "$work" || exit 2
cmake --preset release >cmake.log 2>&1 || { cat cmake.log >&2; exit 2; }
build() { cmake --build build/release --target test_services test_transport >build.log 2>&1; }
build || { tail -40 build.log >&2; exit 2; }

number=0 survivors=0 broken=0
while IFS=$'\t' read -r file from to; do
    case $file in '#'* | '') continue ;; esac
    number=$((number + 1))
    [ "$number" -ge "${1:-1}" ] && [ "$number" -le "${2:-100000}" ] || continue
    cp "$file" kept
    if ! FROM=$from TO=$to perl -0pi -e '$n = s/\Q$ENV{FROM}\E/$ENV{TO}/; END { exit !$n }' "$file"; then
        echo "$number $file: nothing reads '$from'"
        broken=1
    elif ! build; then
        echo "$number $file: '$to' does not compile"
        broken=1
    else
        verdict=SURVIVED
        for program in test_services test_transport; do
            if ! "build/release/$program" '~[.]' --abort -r compact >test.log 2>&1; then
                # The compact reporter prints files instead of cases; file and line of the failure identify the case.
                verdict="fails $(grep -m1 -oE '[a-z_]+\.(cpp|h):[0-9]+: failed' test.log | sed 's/: failed//')"
                break
            fi
        done
        [ "$verdict" = SURVIVED ] && survivors=$((survivors + 1))
        echo "$number $file: '$to': $verdict"
    fi
    cp kept "$file"
done <tests/mutations.txt
echo "$survivors survived"
[ "$broken" = 0 ] || exit 2
[ "$survivors" = 0 ]
