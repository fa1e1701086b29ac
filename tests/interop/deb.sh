#!/bin/sh
# The Debian package: what is in it, then installed, used and removed. As root that happens in this
# system itself behind an overlay, which is thrown away; otherwise in an empty root.
#
#   tests/interop/deb.sh [PACKAGE]      by default that of `make deb`
#
# LMPC_DEB_MOST is how large lmpc itself may be [bytes]. It is set for a program of another profile than
# `dist`: that one is larger, and it names the folder it was built in.
set -eu
cd "$(dirname "$0")/../.."
tests/interop/needs.sh dpkg-deb dpkg gzip
package=$(realpath "${1:-$(ls out/deb/lmpc_*.deb | head -1)}")
most=${LMPC_DEB_MOST:-12000000}
fail() { echo "deb: $1" >&2; exit 1; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

dpkg-deb -x "$package" "$work/x"
size=$(stat -c %s "$work/x/usr/bin/lmpc")
[ "$size" -lt $most ] || fail "lmpc has $size bytes, at most $most are expected"
"$work/x/usr/bin/lmpc" --version | grep -q "^lmpc $(dpkg-deb -f "$package" Version)$" || fail "version"
for page in lmpc lmpc-race lmpc-study-report; do
    gzip -dc "$work/x/usr/share/man/man1/$page.1.gz" | grep -q '^.TH' || fail "no page of $page"
done
for file in etc/lmpc/bridge.env usr/lib/systemd/system/lmpc-bridge.service usr/lib/sysusers.d/lmpc.conf \
    usr/share/bash-completion/completions/lmpc usr/share/zsh/vendor-completions/_lmpc \
    usr/share/fish/vendor_completions.d/lmpc.fish usr/share/doc/lmpc/copyright \
    usr/share/doc/lmpc/third-party-licences.gz usr/share/doc/lmpc/examples/studies/crc.toml; do
    [ -s "$work/x/$file" ] || fail "$file is missing or empty"
done
bash -n "$work/x/usr/share/bash-completion/completions/lmpc"
grep -q '^ExecStart=/usr/bin/lmpc ' "$work/x/usr/lib/systemd/system/lmpc-bridge.service" || fail "unit"
gzip -dc "$work/x/usr/share/doc/lmpc/third-party-licences.gz" | grep -q '^clap ' || fail "licences"
(cd "$work/x" && dpkg-deb -e "$package" "$work/c" && md5sum --quiet -c "$work/c/md5sums")
[ -z "${LMPC_DEB_MOST:-}" ] || rm "$work/x/usr/bin/lmpc"
if grep -rlF "$PWD" "$work/x" >&2; then fail "these files name the folder the package was built in"; fi

# Installs, uses and purges; nothing of it stays but the user of the service.
cat >"$work/inside.sh" <<'INSIDE'
set -eu
package=$1
installed() { dpkg-query -W -f '${Status}' lmpc 2>/dev/null | grep -q '^install ok installed'; }
! command -v lmpc >/dev/null || { echo "another lmpc is installed here" >&2; exit 1; }
dpkg -i --force-depends "$package" >/dev/null
installed
grep -q '^lmpc:' /etc/passwd
cd /tmp
lmpc --quiet race --laps 1 --out /tmp/lmpc-deb >/dev/null
test -s /tmp/lmpc-deb/report.html
lmpc study /usr/share/doc/lmpc/examples/studies/crc.toml --list >/dev/null
command -v systemd-analyze >/dev/null && systemd-analyze verify lmpc-bridge.service
dpkg -i --force-depends "$package" >/dev/null # an upgrade to itself
dpkg --purge lmpc >/dev/null
! installed
for path in /usr/bin/lmpc /etc/lmpc/bridge.env /usr/share/doc/lmpc /usr/share/man/man1/lmpc.1.gz \
    /usr/lib/systemd/system/lmpc-bridge.service; do
    test ! -e "$path" || { echo "$path stays after the purge" >&2; exit 1; }
done
INSIDE
overlay='mount -t tmpfs tmpfs "$1" && mkdir "$1/up" "$1/work" "$1/root" &&
    mount -t overlay overlay -o "lowerdir=/,upperdir=$1/up,workdir=$1/work" "$1/root"'
mkdir "$work/o"
if [ "$(id -u)" = 0 ] && unshare -m sh -c "$overlay" sh "$work/o" 2>/dev/null; then
    unshare -m sh -c "$overlay"' && mount -t proc proc "$1/root/proc" && mount --bind /dev "$1/root/dev" &&
        cp "$2" "$1/root/tmp/lmpc.deb" && cp "$3" "$1/root/tmp/inside.sh" &&
        chroot "$1/root" sh /tmp/inside.sh /tmp/lmpc.deb' sh "$work/o" "$package" "$work/inside.sh"
    echo "deb: installed, used and purged in this system behind an overlay"
else
    root=$work/root
    mkdir -p "$root/var/lib/dpkg/info" "$root/var/lib/dpkg/updates" "$root/etc"
    touch "$root/var/lib/dpkg/status"
    in_root() { fakeroot dpkg --root="$root" --force-script-chrootless --force-depends --log=/dev/null "$@" >/dev/null; }
    in_root -i "$package"
    "$root/usr/bin/lmpc" --quiet race --laps 1 --out "$work/race" >/dev/null
    in_root --purge lmpc
    [ ! -e "$root/usr/bin/lmpc" ] || fail "lmpc stays after the purge"
    echo "deb: installed, used and purged in an empty root (not root: scripts ran outside of it)"
fi
