#!/bin/sh
# Holds the libraries of tools/fmu.sh --windows to a plain C importer: natively under Valgrind, a
# hundred times loaded, run and freed; on Windows under wine, with the same numbers. Also their size,
# what they need, and that no path of this machine is inside. Arguments: FMUs (default out/fmu).
# With --arm64 first, the same for the libraries of tools/fmu.sh --arm64, under qemu; needs
# gcc-aarch64-linux-gnu, libc6-dev-arm64-cross and qemu-user.
set -eu
cd "$(dirname "$0")/.."
arm64=
if [ "${1:-}" = --arm64 ]; then
    arm64=1
    shift
fi
fmus=${1:-out/fmu}
target=${CARGO_TARGET_DIR:-target}
lib=$target/fmu/lib
work=$target/fmu/host
mkdir -p "$work"

gcc -O1 -Wall -Wno-unused-variable -o "$work/host" fmu/tests/host/host.c -ldl
if [ -n "$arm64" ]; then
    aarch64-linux-gnu-gcc -O1 -Wno-unused-variable -o "$work/host-arm64" fmu/tests/host/host.c -ldl
else
    x86_64-w64-mingw32-gcc -O1 -o "$work/host.exe" fmu/tests/host/host.c
    x86_64-w64-mingw32-gcc -shared -o "$work/bcryptprimitives.dll" fmu/tests/host/process_prng.c -ladvapi32
fi
wine=$(command -v wine64 || command -v wine || echo /usr/lib/wine/wine64)
export WINEDEBUG=-all WINEPREFIX="$PWD/$work/wine"

fail() { echo "$*" >&2; exit 1; }

small() { # library: below 4 MiB, no path of this machine
    [ "$(stat -c %s "$1")" -lt 4194304 ] || fail "$1: larger than 4 MiB"
    if strings -a "$1" | grep -F -e "$PWD" -e "$HOME/"; then fail "$1: a path of this machine"; fi
}

modest() { # objdump, library: needs libc and libm alone
    needed=$("$1" -p "$2" | awk '/NEEDED/ { print $2 }' | grep -v -e '^libc\.so' -e '^libm\.so' -e '^ld-linux' || true)
    [ -z "$needed" ] || fail "$2 needs $needed"
}

for name in vehicle controller; do
    xml=$(unzip -p "$fmus/fmi2/lmpc-$name.fmu" modelDescription.xml)
    token=$(echo "$xml" | grep -o ' guid="[^"]*"' | cut -d'"' -f2)
    [ $name = vehicle ] && output=truth.e_y || output=status.steps
    reference=$(echo "$xml" | grep -o "name=\"$output\" valueReference=\"[0-9]*\"" |
        grep -o '[0-9]*"$' | tr -d '"')
    so=$lib/x86_64-unknown-linux-gnu/liblmpc_$name.so
    dll=$lib/x86_64-pc-windows-gnu/lmpc_$name.dll

    native=$("$work/host" "$so" "$token" 1 100 "$reference")
    if [ -n "$arm64" ]; then
        arm=$lib/aarch64-unknown-linux-gnu/liblmpc_$name.so
        small "$arm"
        modest aarch64-linux-gnu-objdump "$arm"
        found=$(qemu-aarch64 -L /usr/aarch64-linux-gnu "$work/host-arm64" "$arm" "$token" 2 100 "$reference")
        [ "$native" = "$found" ] || fail "$name: x64 $native, ARM $found"
        unzip -l "$fmus/fmi3/lmpc-$name.fmu" | grep -q "binaries/aarch64-linux/lmpc_$name.so" ||
            fail "$fmus/fmi3/lmpc-$name.fmu: no library for ARM"
        echo "$name: $(stat -c %s "$arm") bytes; FMI 2 and 3 after 100 steps on ARM: $found, as on x64"
        continue
    fi
    small "$so"
    small "$dll"
    modest objdump "$so"
    cp "$dll" "$work/"
    windows=$(cd "$work" && "$wine" host.exe "lmpc_$name.dll" "$token" 1 100 "$reference" | tr -d '\r')
    [ "$native" = "$windows" ] || fail "$name: Linux $native, Windows $windows"
    valgrind --quiet --leak-check=full --errors-for-leak-kinds=definite,indirect --error-exitcode=9 \
        "$work/host" "$so" "$token" 100 20 "$reference" > /dev/null
    echo "$name: $(stat -c %s "$so") and $(stat -c %s "$dll") bytes; FMI 2 and 3 after 100 steps: $native," \
        "the same under wine; no leak in 100 cycles"
done
