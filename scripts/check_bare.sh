#!/usr/bin/env bash
# Makes a bare Debian 12 and sets Raysweep up in it: what scripts/setup.sh forgets is missing there, whatever this machine has.
set -euo pipefail

usage() {
    cat <<'END'
usage: scripts/check_bare.sh [OPTION...]
Runs scripts/setup.sh and configures in a bare Debian 12 (debootstrap's minbase), with the files of this checkout that git
knows, as they are now, and prints the time of each stage. Needs root, or sudo.
  --demo          then scripts/demo.sh; its pictures are copied out
  --test          then scripts/test.sh
  --run COMMAND   last, bash runs COMMAND in there; may be repeated
  --ccache DIR    a compiler cache to use in there; else everything is compiled
  --if-changed N  only if what setting up rests on has changed in the last N commits; where root cannot be had, says so and ends
                  with 0
  --help
Environment:
  RAYSWEEP_BARE_CACHE  folder for the minimal root and the packages that were downloaded (~/.cache/raysweep/bare); remove it to
                       begin anew. Each run works in a fresh copy of that root beside it, which grows to 2.5 GB and more.
  RAYSWEEP_DATA        data for --test; without it the tests that want it are skipped
END
}

# What setting up rests on, as extended regular expression for whole paths.
rests_on='scripts/(setup|check_bare)\.sh|\.ci/run|CMakePresets\.json|(.*/)?CMakeLists\.txt|cmake/.*'
release=bookworm
here=/raysweep # the checkout's place in the root

script=$(realpath "$0")
checkout=$(dirname "$(dirname "$script")")
arguments=("$@")
cache=$(realpath -m "${RAYSWEEP_BARE_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/raysweep/bare}")
data=${RAYSWEEP_DATA:+$(realpath -m "$RAYSWEEP_DATA")}
demo="" test="" ccache="" if_changed="" root="" running="" under_way=""
commands=()

say() { echo "== bare: $*"; }
in_git() { git -C "$checkout" "$@"; }

# Ends for want of something that is no fault of the checkout: a failure, unless --if-changed asked in passing.
give_up() {
    [ -z "$if_changed" ] || { say "skipped: $*" && exit 0; }
    echo "check_bare.sh: $*" >&2
    exit 1
}

parse() {
    while [ $# -gt 0 ]; do
        case $1 in
            --demo) demo=yes ;;
            --test) test=yes ;;
            --run) commands+=("${2:?--run needs a command}") && shift ;;
            --ccache) ccache=$(realpath -m "${2:?--ccache needs a folder}") && shift ;;
            --if-changed)
                [[ ${2:-} =~ ^[0-9]+$ ]] || { echo "check_bare.sh: --if-changed needs a number of commits" >&2 && exit 2; }
                if_changed=$2 && shift
                ;;
            -h | --help) usage && exit 0 ;;
            *) usage >&2 && exit 2 ;;
        esac
        shift
    done
}

# A checkout without git may be passed over. One that git refuses to read (as somebody else's) may not: CI would check nothing.
require_git() {
    local reason
    reason=$(in_git rev-parse HEAD 2>&1 >/dev/null) && return
    [ ! -e "$checkout/.git" ] || { echo "check_bare.sh: $reason" >&2 && exit 1; }
    give_up "needs a checkout made by git"
}

# In a shallow clone the oldest commit counts as having changed every file: what is unknown is checked.
skip_if_unchanged() {
    local changed
    changed=$(in_git log -n "$if_changed" --format= --name-only && in_git diff --name-only HEAD)
    grep -qxE "$rests_on" <<<"$changed" && return
    say "skipped: nothing that setting up rests on has changed in $if_changed commits"
    exit 0
}

become_root() {
    [ "$(id -u)" -eq 0 ] && return
    command -v sudo >/dev/null || give_up "needs root (debootstrap, mount and chroot do), and there is no sudo"
    [ -z "$if_changed" ] || sudo -n true 2>/dev/null || give_up "needs root, and sudo wants a password"
    exec sudo --preserve-env=http_proxy,https_proxy,no_proxy RAYSWEEP_BARE_CACHE="$cache" ${data:+RAYSWEEP_DATA="$data"} \
        "$script" "${arguments[@]}"
}

require_tools() {
    unshare --mount --pid --fork true 2>/dev/null || give_up "may not mount here (a container without the right to?)"
    command -v debootstrap >/dev/null && return
    { apt-get update -qq && apt-get install -y -qq --no-install-recommends debootstrap; } >/dev/null 2>&1 ||
        give_up "debootstrap is missing, and apt-get cannot install it"
}

# What this machine's apt reads Debian 12 from, as lines of sources.list: it may be the only mirror in reach.
sources() {
    apt-get indextargets --format 'deb $(REPO_URI) $(CODENAME) $(COMPONENT)' 'Created-By: Packages' 2>/dev/null |
        grep -E "^deb [^ ]+ $release(-updates|-security)? main$" | sort -u || true
}

make_sources() {
    [ -n "$(sources)" ] || apt-get update -qq 2>/dev/null || true
    sources >"$cache/sources.list"
    [ -s "$cache/sources.list" ] || cat >"$cache/sources.list" <<END
deb http://deb.debian.org/debian $release main
deb http://deb.debian.org/debian $release-updates main
deb http://deb.debian.org/debian-security $release-security main
END
}

# In a namespace of its own: debootstrap's mounts end with it, even if it is killed.
make_minimal() {
    local mirror
    mirror=$(awk -v release=$release '$3 == release {print $2; exit}' "$cache/sources.list")
    rm -rf --one-file-system "$cache/minimal.part"
    unshare --mount --pid --fork --kill-child --mount-proc \
        debootstrap --variant=minbase $release "$cache/minimal.part" "$mirror" >"$cache/debootstrap.log" &
    await || { tail -n 5 "$cache/debootstrap.log" >&2 && give_up "debootstrap failed (all it said: $cache/debootstrap.log)"; }
    mv "$cache/minimal.part" "$cache/minimal"
}

# A fresh copy of the minimal root that reaches the network and the packages as this machine does: names, sources, keys, and how
# apt fetches (proxies), but not what it installs.
make_root() {
    rm -rf --one-file-system "$cache"/run.*
    root=$(mktemp -d "$cache/run.XXXXXX")
    cp -a --reflink=auto "$cache/minimal/." "$root"
    chmod 755 "$root"
    { : >"$root/dev/null"; } 2>/dev/null || give_up "$cache is on a file system without devices: set RAYSWEEP_BARE_CACHE"
    cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
    cp "$cache/sources.list" "$root/etc/apt/sources.list"
    cp -a /etc/apt/trusted.gpg.d /etc/apt/auth.conf.d "$root/etc/apt/" 2>/dev/null || true
    apt-config dump | grep '^Acquire::' >"$root/etc/apt/apt.conf.d/90host" || true
    echo force-unsafe-io >"$root/etc/dpkg/dpkg.cfg.d/unsafe-io" # it will not outlive a crash anyway: no waiting for the disk
    mkdir -p "$root$here" "$root/ccache" "$root/data" "$cache/archives"
    in_git ls-files -z | tar -C "$checkout" --create --ignore-failed-read --null --files-from=- |
        tar --extract --no-same-owner -C "$root$here"
}

# Runs COMMAND in the root, in the namespace of its own in which it is called: no mount is seen from outside, and all mounts and
# processes end with it. Debian's minimal /dev is the root's own.
enter() {
    local environment=(PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root) name
    mount -t proc proc "$root/proc"
    mount -t sysfs -o ro sysfs "$root/sys"
    mount -t devpts -o newinstance,ptmxmode=0666 devpts "$root/dev/pts"
    mount -t tmpfs tmpfs "$root/dev/shm"
    mount --bind "$cache/archives" "$root/var/cache/apt/archives"
    if [ -n "$data" ]; then
        mount --bind -o ro "$data" "$root/data"
        environment+=(RAYSWEEP_DATA=/data)
    fi
    if [ -n "$ccache" ]; then
        mount --bind "$ccache" "$root/ccache"
        environment+=(CCACHE_DIR=/ccache) # the rest is said by scripts/ccache.sh, for all that build
    fi
    for name in http_proxy https_proxy no_proxy; do
        [ -z "${!name:-}" ] || environment+=("$name=${!name}")
    done
    exec chroot "$root" env -i "${environment[@]}" bash -ec "cd $here; $1"
}

# In the background, because bash lets nothing interrupt what runs before it.
await() {
    running=$!
    local code=0
    wait "$running" || code=$?
    running=""
    return $code
}

# stage NAME COMMAND...: says how long it took. If it fails, the script ends there, and clean_up says in which stage.
stage() {
    local start=$SECONDS
    under_way=$1
    say "$under_way"
    "${@:2}"
    say "$under_way took $((SECONDS - start)) s"
    under_way=""
}

in_root() {
    unshare --mount --pid --fork --kill-child bash -euc "$(declare -f enter); enter \"\$1\"" enter "$1" &
    await
}

# What unshare started is the first process of its namespace: with it all others there end.
clean_up() {
    local code=$?
    trap '' INT TERM HUP # a second Ctrl-C must not leave half of it
    [ $code -eq 0 ] || [ -z "$under_way" ] || say "$under_way FAILED (exit $code) after $SECONDS s in all"
    [ -z "$running" ] || { kill -KILL "$running" && wait "$running"; } 2>/dev/null || true
    [ -z "$root" ] || rm -rf --one-file-system "$root"
}

copy_pictures() {
    mkdir -p "$cache/demo"
    cp "$root$here"/demo/*.png "$root$here"/demo/*.json "$cache/demo/"
    say "pictures: $(echo "$cache"/demo/*.png)"
}

main() {
    parse "$@"
    require_git
    [ -z "$if_changed" ] || skip_if_unchanged
    become_root
    require_tools

    mkdir -p "$cache" ${ccache:+"$ccache"}
    exec 9>"$cache/lock"
    flock --nonblock 9 || { say "waits for another run" && flock 9; }
    trap clean_up EXIT
    trap 'exit 130' INT
    trap 'exit 143' TERM HUP
    export root cache data ccache here

    make_sources
    [ -d "$cache/minimal" ] || stage "minimal root (debootstrap)" make_minimal
    stage "fresh copy" make_root
    stage "scripts/setup.sh" in_root "scripts/setup.sh"
    # ITK is optional, so that only asking for it shows that it is missing.
    stage "cmake --preset release" in_root "cmake --preset release -DRAYSWEEP_WITH_ITK=ON >/dev/null"
    if [ -n "$demo" ]; then
        stage "scripts/demo.sh" in_root "scripts/demo.sh"
        copy_pictures
    fi
    [ -z "$test" ] || stage "scripts/test.sh" in_root "scripts/test.sh"
    local command
    for command in "${commands[@]}"; do stage "$command" in_root "$command"; done
    in_root "apt-get -qq autoclean" >/dev/null
    say "all well after $SECONDS s; the root $(du -sxh "$root" | cut -f1), packages $(du -sh "$cache/archives" | cut -f1)"
}

main "$@"
