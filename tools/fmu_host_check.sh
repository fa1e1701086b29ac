#!/bin/sh
# Holds the libraries of tools/fmu.sh --windows to a plain C importer: natively under Valgrind, a
# hundred times loaded, run and freed; on Windows under wine, with the same numbers. Also their size,
# what they need, and that no path of this machine is inside. Arguments: FMUs (default out/fmu).
set -eu
cd "$(dirname "$0")/.."
fmus=${1:-out/fmu}
target=${CARGO_TARGET_DIR:-target}
lib=$target/fmu/lib
work=$target/fmu/host
mkdir -p "$work"

gcc -O1 -Wall -Wno-unused-variable -o "$work/host" fmu/tests/host/host.c -ldl
x86_64-w64-mingw32-gcc -O1 -o "$work/host.exe" fmu/tests/host/host.c
x86_64-w64-mingw32-gcc -shared -o "$work/bcryptprimitives.dll" fmu/tests/host/process_prng.c -ladvapi32
wine=$(command -v wine64 || command -v wine || echo /usr/lib/wine/wine64)
export WINEDEBUG=-all WINEPREFIX="$PWD/$work/wine"

fail() { echo "$*" >&2; exit 1; }

for name in vehicle controller; do
    xml=$(unzip -p "$fmus/fmi2/lmpc-$name.fmu" modelDescription.xml)
    token=$(echo "$xml" | grep -o ' guid="[^"]*"' | cut -d'"' -f2)
    [ $name = vehicle ] && output=truth.e_y || output=status.steps
    reference=$(echo "$xml" | grep -o "name=\"$output\" valueReference=\"[0-9]*\"" |
        grep -o '[0-9]*"$' | tr -d '"')
    so=$lib/x86_64-unknown-linux-gnu/liblmpc_$name.so
    dll=$lib/x86_64-pc-windows-gnu/lmpc_$name.dll

    for file in "$so" "$dll"; do
        [ "$(stat -c %s "$file")" -lt 4194304 ] || fail "$file: larger than 4 MiB"
        if strings -a "$file" | grep -F -e "$PWD" -e "$HOME/"; then fail "$file: a path of this machine"; fi
    done
    needed=$(objdump -p "$so" | awk '/NEEDED/ { print $2 }' | grep -v -e '^libc\.so' -e '^libm\.so' -e '^ld-linux' || true)
    [ -z "$needed" ] || fail "$so needs $needed"

    native=$("$work/host" "$so" "$token" 1 100 "$reference")
    cp "$dll" "$work/"
    windows=$(cd "$work" && "$wine" host.exe "lmpc_$name.dll" "$token" 1 100 "$reference" | tr -d '\r')
    [ "$native" = "$windows" ] || fail "$name: Linux $native, Windows $windows"
    valgrind --quiet --leak-check=full --errors-for-leak-kinds=definite,indirect --error-exitcode=9 \
        "$work/host" "$so" "$token" 100 20 "$reference" > /dev/null
    echo "$name: $(stat -c %s "$so") and $(stat -c %s "$dll") bytes; FMI 2 and 3 after 100 steps: $native," \
        "the same under wine; no leak in 100 cycles"
done
