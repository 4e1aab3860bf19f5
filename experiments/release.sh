#!/usr/bin/env bash
# Makes a release of the commit that is checked out: source archive, Debian packages, change log and checksums.
#   bash experiments/release.sh [OUT]     OUT defaults to build/release-VERSION
# Exit codes: 0 made, 2 something is missing, or files differ from the commit.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
version=$(sed -n 's/^project(raylex VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
case "${1:-}" in -*) sed -n '2,4s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 2 ;; esac
out=${1:-build/release-$version}
stop() { echo "release.sh: $1" >&2; exit 2; }
[ -z "$(git status --porcelain)" ] || stop "files differ from the commit; commit or remove the changes"
bash experiments/install_packages.sh dpkg-dev file || exit 2
mkdir -p "$out"
out=$(cd "$out" && pwd)
git archive --prefix="raylex-$version/" -o "$out/raylex-$version.tar.gz" HEAD
last=$(git describe --tags --abbrev=0 HEAD^ 2>/dev/null || true)   # none: the whole history
git log --no-merges --format='- %s' ${last:+"$last.."}HEAD >"$out/CHANGES.md"
cmake --preset release
cmake --build --preset release --target raylex_installed
cpack --config build/release/CPackConfig.cmake -B "$out"
rm -rf "$out/_CPack_Packages"
(cd "$out" && sha256sum -- *.tar.gz *.deb CHANGES.md >SHA256SUMS)
ls -l "$out"
