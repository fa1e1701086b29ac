#!/bin/sh
# Drives both libraries of tools/fmu.sh through one race with learned laps and holds its hash to be
# one: FMI 2.0 and 3.0; Linux x64, Windows under wine, ARM64 under qemu; whatever the host's
# floating-point state is before everything, after initialisation or in every other step; in a
# thread with 64 KiB of stack. usage: tools/fmu_bits.sh [FMUS], default out/fmu
set -eu
cd "$(dirname "$0")/.."
. tools/fmu_race.sh
fmus=${1:-out/fmu}
lib=${CARGO_TARGET_DIR:-target}/fmu/lib
work=${CARGO_TARGET_DIR:-target}/fmu/host
mkdir -p "$work"
steps=1000

fail() { echo "$*" >&2; exit 1; }
command -v qemu-aarch64 >/dev/null || fail "qemu-aarch64 is missing: apt-get install qemu-user"
wine=$(command -v wine64 || command -v wine || echo /usr/lib/wine/wine64)
[ -x "$wine" ] || fail "wine is missing: apt-get install wine64"
export WINEDEBUG=-all WINEPREFIX="$PWD/$work/wine"
case $work in /*) WINEPREFIX=$work/wine ;; esac

tools/fmu_references.sh "$fmus" > "$work/references"
race_for "x86_64-linux-gnu.$GLIBC" "$work/race"
race_for "aarch64-linux-gnu.$GLIBC" "$work/race-arm64"
race_for x86_64-windows-gnu "$work/race.exe"
x86_64-w64-mingw32-gcc -shared -o "$work/bcryptprimitives.dll" fmu/tests/host/process_prng.c \
    -ladvapi32
cp "$lib"/x86_64-pc-windows-gnu/*.dll "$work/"

linux() { # program's prefix, program, platform, then what race.c takes after the references
    prefix=$1 program=$2 folder=$lib/$3-unknown-linux-gnu
    shift 3
    # shellcheck disable=SC2086 # no word or several
    $prefix "$work/$program" "$folder/liblmpc_controller.so" "$folder/liblmpc_vehicle.so" \
        "$work/references" "$@"
}
x64() { linux "" race x86_64 "$@"; }
arm() { linux "qemu-aarch64 -L /usr/aarch64-linux-gnu" race-arm64 aarch64 "$@"; }
windows() {
    (cd "$work" && "$wine" race.exe lmpc_controller.dll lmpc_vehicle.dll references "$@" | tr -d '\r')
}

same() { # what it is, what was found
    [ "$2" = "$expected" ] || fail "$1: $2, expected $expected (hash, learned steps, laps)"
}
expected=$(x64 2 $steps)
set -- $expected
[ "$2" -gt $((steps / 2)) ] || fail "only $2 of $steps steps were learned ones"
same "FMI 3.0" "$(x64 3 $steps)"
same "FMI 2.0, Windows" "$(windows 2 $steps)"
same "FMI 3.0, Windows" "$(windows 3 $steps)"
same "FMI 3.0, ARM64" "$(arm 3 $steps)"
for version in 2 3; do
    same "FMI $version, 64 KiB of stack" "$(x64 $version $steps nearest 0 64)"
    for state in up down zero trap flush; do
        for when in 0 1 2; do
            same "FMI $version, host's state $state, $when" "$(x64 $version $steps $state $when)"
        done
    done
done
echo "$steps steps: $expected (hash, learned steps, laps) on x64, Windows and ARM64, FMI 2.0 and" \
    "3.0, in every floating-point state of the host and with 64 KiB of stack"

# ARM64 under qemu is slow, and may not have traps.
expected=$(x64 2 300)
for state in up down zero flush; do
    same "FMI 2, ARM64, host's state $state" "$(arm 2 300 $state 2)"
done
echo "the same on ARM64 in 300 steps"
