#!/bin/sh
# Holds the libraries of tools/fmu.sh to plain C importers: natively under Valgrind, loaded, run and
# freed again and again; the same race natively, on Windows under wine and on ARM64 under qemu, with
# the same bits whatever floating-point state the host has. Also their size, the glibc and libraries
# they need, the stack they take, and that no path of this machine is inside.
# Arguments: FMUs (default out/fmu).
set -eu
cd "$(dirname "$0")/.."
. tools/zig.sh
fmus=${1:-out/fmu}
target=${CARGO_TARGET_DIR:-target}
lib=$target/fmu/lib
work=$target/fmu/host
mkdir -p "$work"
work=$(cd "$work" && pwd)
x64=$lib/x86_64-unknown-linux-gnu arm64=$lib/aarch64-unknown-linux-gnu win=$lib/x86_64-pc-windows-gnu
# Four learned laps in ten of the small car's.
steps=1000
# Thread stack a host must give: documented in fmu/README.md.
stack_kib=64

fail() { echo "$*" >&2; exit 1; }

python-zig cc -target "x86_64-linux-gnu.$GLIBC" -O1 -o "$work/race" fmu/tests/host/race.c
python-zig cc -target "aarch64-linux-gnu.$GLIBC" -O1 -o "$work/race-arm64" fmu/tests/host/race.c
x86_64-w64-mingw32-gcc -O1 -o "$work/race.exe" fmu/tests/host/race.c
gcc -O1 -Wall -Wno-unused-variable -o "$work/host" fmu/tests/host/host.c -ldl
x86_64-w64-mingw32-gcc -O1 -o "$work/host.exe" fmu/tests/host/host.c
x86_64-w64-mingw32-gcc -shared -o "$work/bcryptprimitives.dll" fmu/tests/host/process_prng.c -ladvapi32
wine=$(command -v wine64 || command -v wine || echo /usr/lib/wine/wine64)
export WINEDEBUG=-all WINEPREFIX="$work/wine"

echo "== what the libraries need"
tools/glibc_floor.sh "$GLIBC" "$x64"/*.so "$arm64"/*.so
for file in "$x64"/*.so "$arm64"/*.so "$win"/*.dll; do
    [ "$(stat -c %s "$file")" -lt 4194304 ] || fail "$file: larger than 4 MiB"
    if strings -a "$file" | grep -F -e "$PWD" -e "$HOME/"; then fail "$file: a path of this machine"; fi
done
for name in vehicle controller; do
    unzip -l "$fmus/fmi3/lmpc-$name.fmu" | grep -q "binaries/aarch64-linux/lmpc_$name.so" ||
        fail "$fmus/fmi3/lmpc-$name.fmu: no library for ARM"
done

echo "== one race on three platforms"
tools/fmu_references.sh "$fmus" > "$work/references"
cp "$win"/*.dll "$work/"
native() { "$work/race" "$x64/liblmpc_controller.so" "$x64/liblmpc_vehicle.so" "$work/references" "$@"; }
arm() { qemu-aarch64 -L /usr/aarch64-linux-gnu "$work/race-arm64" "$arm64/liblmpc_controller.so" \
    "$arm64/liblmpc_vehicle.so" "$work/references" "$@"; }
windows() { (cd "$work" && "$wine" race.exe lmpc_controller.dll lmpc_vehicle.dll references "$@") | tr -d '\r'; }
expected=$(native 2 $steps)
learned=$(echo "$expected" | cut -d' ' -f2)
[ "$learned" -gt 500 ] || fail "only $learned of $steps steps were learned ones"
same() { # what, its output
    [ "$2" = "$expected" ] || fail "$1: $2; Linux x64, FMI 2: $expected"
    echo "$1: $2"
}
for version in 2 3; do
    same "FMI $version, Linux x64" "$(native $version $steps)"
    same "FMI $version, Windows under wine" "$(windows $version $steps)"
    same "FMI $version, ARM64 under qemu" "$(arm $version $steps)"
done

echo "== whatever floating-point state the host has"
for version in 2 3; do
    # Before everything, after initialisation, in every other step.
    for when in 0 1 2; do
        for state in up down zero trap flush; do
            same "FMI $version, host state '$state' from $when" "$(native $version $steps $state $when)"
        done
    done
    same "FMI $version, wine, rounding up" "$(windows $version $steps up 0)"
    same "FMI $version, qemu ARM64, rounding up" "$(arm $version $steps up 0)"
    same "FMI $version, a thread of $stack_kib KiB" "$(native $version $steps nearest 0 $stack_kib)"
done

echo "== the static library: as the FMU, and its example"
link="-L$x64 -llmpc_c -lgcc_eh -lpthread -ldl -lm"
# shellcheck disable=SC2086 # one word per argument
gcc -O1 -DSTATIC_CONTROLLER -Ifmu/capi -o "$work/race-static" fmu/tests/host/race.c $link
for state in nearest up trap flush; do
    same "static library, host state '$state'" "$("$work/race-static" - "$x64/liblmpc_vehicle.so" \
        "$work/references" 2 $steps $state 0)"
done
# shellcheck disable=SC2086
gcc -O1 -Wall -Wextra -Ifmu/capi -o "$work/example" fmu/capi/example.c $link
valgrind --quiet --leak-check=full --errors-for-leak-kinds=definite,indirect --error-exitcode=9 \
    "$work/example"

echo "== loaded, run and freed"
for name in vehicle controller; do
    xml=$(unzip -p "$fmus/fmi2/lmpc-$name.fmu" modelDescription.xml)
    token=$(echo "$xml" | sed -n 's/.* guid="\([^"]*\)".*/\1/p')
    [ $name = vehicle ] && output=truth.e_y || output=status.steps
    reference=$(echo "$xml" | sed -n "s/.*name=\"$output\" valueReference=\"\([0-9]*\)\".*/\1/p")
    valgrind --quiet --leak-check=full --errors-for-leak-kinds=definite,indirect --error-exitcode=9 \
        "$work/host" "$x64/liblmpc_$name.so" "$token" 20 20 "$reference" > /dev/null
    # Loaded and freed a thousand times: growth in KiB per time, which the importer holds to 100.
    "$work/host" "$x64/liblmpc_$name.so" "$token" 1000 2 "$reference" 100
    (cd "$work" && "$wine" host.exe "lmpc_$name.dll" "$token" 1000 2 "$reference" 100)
done
