#!/usr/bin/env bash
# Installs the missing Debian packages of packages.txt, for the quickstart, the tests and CI. Does nothing if all are
# installed. Exit code 2 with the exact command if it may not install.
#   bash experiments/install_packages.sh [PACKAGE...]   also installs further packages
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
mapfile -t wanted < <(sed 's/#.*//' "$here/packages.txt" | tr -s ' \t' '\n' | sed '/^$/d')
wanted+=("$@")

missing=()
for package in "${wanted[@]}"; do
    status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) || status=""
    [ "$status" = installed ] || missing+=("$package")
done
# Another cmake in PATH, before Debian's, may be too old.
version=$(cmake --version 2>/dev/null | sed -n '1s/[^0-9]*//p')
if [ -n "$version" ] && ! printf '3.25\n%s\n' "$version" | sort -CV; then
    echo "$(command -v cmake) is CMake $version; raylex needs 3.25 or later (Debian: apt-get install cmake)" >&2
    exit 2
fi
[ ${#missing[@]} -eq 0 ] && exit 0
if ! command -v apt-get >/dev/null; then
    echo "This system has no apt-get; expected Debian 12 or 13. Please install what corresponds to: ${missing[*]}" >&2
    exit 2
fi

command=(apt-get install -y --no-install-recommends "${missing[@]}")
if [ "$(id -u)" = 0 ]; then
    as_root=()
elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
    as_root=(sudo)
elif command -v sudo >/dev/null 2>&1 && [ -t 0 ]; then
    as_root=(sudo)
else
    echo "These packages are missing and installing them needs root. Please run:" >&2
    echo "  sudo apt-get update && sudo ${command[*]}" >&2
    exit 2
fi

echo "Installing ${#missing[@]} packages: ${missing[*]}"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
export DEBIAN_FRONTEND=noninteractive
# If the package list was never fetched, the first try fails; only then it is fetched.
if ! "${as_root[@]}" "${command[@]}" >"$log" 2>&1; then
    if ! { "${as_root[@]}" apt-get update && "${as_root[@]}" "${command[@]}"; } >"$log" 2>&1; then
        tail -n 20 "$log" >&2
        echo "Installing failed. The command was: ${as_root[*]} ${command[*]}" >&2
        exit 2
    fi
fi
