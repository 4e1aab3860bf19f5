#!/usr/bin/env bash
# Installs the Debian packages of a Release build in a Debian of its own, made by debootstrap, and renders with them.
#   bash tests/packages.sh [BUILD [SUITE]]   BUILD defaults to build/release, SUITE to this system's; needs root. BUILD
#                                            may also be a folder with the packages of another Debian
# Prints "N passed, N failed"; or SKIPPED and why; exit 1 if something failed, 2 if it cannot begin.
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$(cd "${1:-$root/build/release}" && pwd) || exit 2
suite=${2:-$(. /etc/os-release && echo "$VERSION_CODENAME")}
. "$root/tests/support/debian_system.sh"
[ -z "$(why_no_debian)" ] || { echo "SKIPPED packages: $(why_no_debian)"; exit 0; }
bash "$root/experiments/install_packages.sh" lintian dpkg-dev || exit 2
work=$(mktemp -d)
trap 'rm -rf --one-file-system "$work"' EXIT
passed=0 failed=0
check() {
    local name=$1
    shift
    if "$@" >"$work/log" 2>&1; then passed=$((passed + 1)); echo "ok: $name"; else
        failed=$((failed + 1)); echo "FAILED: $name"; tail -n 30 "$work/log"; fi
}
inside() { in_debian "$work/system" "set -e; $1"; }
pack() {
    cpack --config "$build/CPackConfig.cmake" -B "$work/made" &&
        [ "$(find "$work/made" -maxdepth 1 -name '*.deb' | wc -l)" = 3 ]
}

if [ -e "$build/CPackConfig.cmake" ]; then check "cpack makes three packages" pack; else
    mkdir "$work/made"
    check "three packages" cp "$build"/{libraylex-dev,python3-raylex,raylex}_*.deb "$work/made"; fi
check "lintian finds no error" lintian --allow-root --fail-on error "$work"/made/*.deb
make_debian "$suite" "$work/system" || exit 2
cp "$work"/made/*.deb "$work/system/root/"
install="apt-get install -y --no-install-recommends"
check "apt fetches its lists" inside "apt-get update"
started=$(date +%s)
check "apt installs the program" inside "$install ./raylex_*.deb"
job=/usr/share/raylex/quickstart/window-light.toml
check "the first picture" inside "raylex render $job --spp 8 -o a.exr --preview a.png; [ -s a.png ]"
echo "measured: $(($(date +%s) - started)) s from apt install to the first picture"
check "the program finds its files" inside "raylex stability --list
    raylex stability --list --plugin planted_error
    raylex render /usr/share/raylex/scenes/prism/scene.pbrt --commands=make --shards 2
    [ -s /usr/share/man/man1/raylex-render.1.gz ]"
check "Python's module renders" inside "$install ./python3-raylex_*.deb
    python3 -c 'import raylex
scene = raylex.Scene(\"/usr/share/raylex/scenes/cornell-grey/scene.pbrt\")
assert raylex.render(scene, spp=1)[\"beauty\"].max() > 0'"
check "a plugin builds with the development files" inside "$install ./libraylex-dev_*.deb g++ cmake make pkg-config
    raylex new plugin frosted --kind filter
    cmake -S frosted -B b
    cmake --build b
    ctest --test-dir b --output-on-failure"
check "pkg-config links a program" inside "echo '#include \"transport/render/render.h\"
int main() { return raylex::transport::render({}, {}) ? 1 : 0; }' >a.cpp
    g++ -std=c++20 a.cpp \$(pkg-config --cflags --libs raylex) -o a
    ./a"
check "apt removes them" inside "apt-get remove -y raylex; [ ! -e /usr/share/raylex ]; [ ! -e /usr/bin/raylex ]"
echo "$passed passed, $failed failed"
[ "$failed" = 0 ]
