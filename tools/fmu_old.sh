#!/bin/sh
# Loads and runs the FMUs' libraries and starts the program in a Debian 11 (glibc 2.31) made for it
# below target/old: the race there must have the bits of the race here. Needs root for the chroot.
# Arguments: FMUs (default out/fmu).
set -eu
cd "$(dirname "$0")/.."
. tools/zig.sh
fmus=${1:-out/fmu}
target=${CARGO_TARGET_DIR:-target}
lib=$target/fmu/lib/x86_64-unknown-linux-gnu
root=$(mkdir -p "$target/old" && cd "$target/old" && pwd)/bullseye
PATH="$PATH:/usr/sbin"
[ "$(id -u)" = 0 ] || { echo "tools/fmu_old.sh needs root: sudo make fmu-old" >&2; exit 1; }
if [ ! -e "$root/ready" ]; then
    debootstrap --variant=minbase bullseye "$root" "${DEBIAN_MIRROR:-http://deb.debian.org/debian}"
    touch "$root/ready"
fi
mkdir -p "$root/fmu"
python-zig cc -target "x86_64-linux-gnu.$GLIBC" -O1 -o "$root/fmu/race" fmu/tests/host/race.c
tools/fmu_references.sh "$fmus" > "$root/fmu/references"
cp "$lib"/*.so "$root/fmu/"
for version in 2 3; do
    here=$("$root/fmu/race" "$lib/liblmpc_controller.so" "$lib/liblmpc_vehicle.so" \
        "$root/fmu/references" $version 1000)
    there=$(chroot "$root" /fmu/race /fmu/liblmpc_controller.so /fmu/liblmpc_vehicle.so \
        /fmu/references $version 1000)
    [ "$here" = "$there" ] || { echo "FMI $version: here $here, Debian 11 $there" >&2; exit 1; }
    echo "FMI $version, 1000 steps in Debian 11: $there, as here"
done
cp out/release/x86_64/lmpc "$root/fmu/lmpc"
chroot "$root" /fmu/lmpc --quiet race --laps 2 --out /fmu/race-out > /dev/null
lines=$(wc -l < "$root/fmu/race-out/trajectory.csv")
[ "$lines" -gt 100 ] || { echo "lmpc race in Debian 11 wrote $lines lines" >&2; exit 1; }
echo "lmpc race in Debian 11: $lines lines, without liblcm"
