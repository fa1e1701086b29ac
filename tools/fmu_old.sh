#!/bin/sh
# Loads and runs both libraries of tools/fmu.sh in a Debian 11 (glibc 2.31), which debootstrap makes
# once below target/old, and compares the race with this system's. Needs root for the chroot.
# usage: tools/fmu_old.sh [FMUS], default out/fmu; MIRROR is where Debian 11 comes from
set -eu
cd "$(dirname "$0")/.."
. tools/fmu_race.sh
fmus=${1:-out/fmu}
target=${CARGO_TARGET_DIR:-target}
lib=$target/fmu/lib/x86_64-unknown-linux-gnu
root=$target/old/bullseye
steps=300

PATH="$PATH:/usr/sbin"
command -v debootstrap >/dev/null || {
    echo "debootstrap is missing: apt-get install debootstrap" >&2
    exit 1
}
sudo=""
[ "$(id -u)" = 0 ] || sudo=sudo
if [ ! -e "$target/old/done" ]; then
    mkdir -p "$target/old"
    $sudo rm -rf "$root"
    $sudo debootstrap --variant=minbase bullseye "$root" \
        "${MIRROR:-http://deb.debian.org/debian}" > "$target/old/log" 2>&1 || {
        tail -5 "$target/old/log" >&2
        echo "no Debian 11 from ${MIRROR:-http://deb.debian.org/debian}; MIRROR names another" >&2
        exit 1
    }
    touch "$target/old/done"
fi

place=$root/lmpc
$sudo mkdir -p "$place"
race_for "x86_64-linux-gnu.$GLIBC" "$target/old/race"
tools/fmu_references.sh "$fmus" > "$target/old/references"
$sudo cp "$target/old/race" "$target/old/references" "$lib"/*.so "$place/"
for version in 2 3; do
    here=$("$target/old/race" "$lib/liblmpc_controller.so" "$lib/liblmpc_vehicle.so" \
        "$target/old/references" $version $steps)
    there=$($sudo chroot "$root" /lmpc/race /lmpc/liblmpc_controller.so /lmpc/liblmpc_vehicle.so \
        /lmpc/references $version $steps)
    [ "$here" = "$there" ] || { echo "FMI $version: here $here, Debian 11 $there" >&2; exit 1; }
    echo "FMI $version in Debian 11, $($sudo chroot "$root" ldd --version | head -1):" \
        "$steps steps, $there (hash, learned steps, laps), as here"
done
tools/release.sh x86_64
$sudo cp out/release/x86_64/lmpc "$place/"
$sudo chroot "$root" /lmpc/lmpc --quiet race --laps 2 --out /lmpc/out > /dev/null
lines=$(wc -l < "$place/out/trajectory.csv")
[ "$lines" -gt 100 ] || { echo "lmpc race in Debian 11 wrote $lines lines" >&2; exit 1; }
echo "lmpc race in Debian 11: $lines lines, without liblcm"
