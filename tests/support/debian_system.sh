# Sourced by the scripts that need a Debian of their own: tests/debian13.sh, tests/arm64.sh and tests/packages.sh.

# why_no_debian: prints why this machine cannot have a Debian of its own in a folder; nothing if it can.
why_no_debian() {
    if [ "$(id -u)" != 0 ]; then
        echo "a chroot needs root"
    elif ! unshare --mount --pid --fork true 2>/dev/null; then
        echo "this machine forbids namespaces of mounts and processes"
    fi
}

# make_debian SUITE FOLDER: installs a Debian in FOLDER, from the package mirror of this machine's apt. Prints why not,
# and fails, if it cannot.
make_debian() {
    local suite=$1 system=$2 mirror
    mirror_of_apt() {
        apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' 'Label: Debian' \
            'Component: main' | head -n 1
    }
    bash "$root/experiments/install_packages.sh" debootstrap || return
    mirror=$(mirror_of_apt)
    [ -n "$mirror" ] || { apt-get update >/dev/null && mirror=$(mirror_of_apt); }
    [ -n "$mirror" ] || { echo "apt has no mirror of Debian among its sources; expected one that has $suite"; return 1; }
    rm -rf --one-file-system "$system"
    mkdir -p "$system"
    debootstrap --variant=minbase --include=ca-certificates "$suite" "$system" "$mirror" >"$system.log" 2>&1 ||
        { tail -n 20 "$system.log"; echo "debootstrap failed; its messages are in $system.log"; return 1; }
    cp -L /etc/resolv.conf "$system/etc/resolv.conf"
    mkdir "$system/raylex"
}

# in_debian FOLDER COMMAND [VARIABLE=VALUE...]: runs a line of bash in the Debian in FOLDER. It has namespaces of mounts
# and processes of its own, so that nothing stays when it ends. With `built`, it starts in /raylex, which is this clone,
# and the clone's build/ is the folder `built`.
in_debian() {
    local system=$1 command=$2
    shift 2
    unshare --mount --pid --fork --kill-child --mount-proc="$system/proc" bash -c '
        system=$1 command=$2 clone=$3 built=$4 folder=/root
        shift 4
        mount --rbind /dev "$system/dev" || exit
        if [ -n "$built" ]; then
            folder=/raylex
            mkdir -p "$built"
            mount --bind "$clone" "$system/raylex" && mount --bind "$built" "$system/raylex/build" || exit
        fi
        exec chroot "$system" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 \
            DEBIAN_FRONTEND=noninteractive http_proxy="${http_proxy:-}" https_proxy="${https_proxy:-}" "$@" \
            bash -c "cd $folder && $command"' bash "$system" "$command" "$root" "${built:-}" "$@"
}
