#!/bin/sh
# Holds the libraries of tools/fmu.sh to plain C importers: natively under Valgrind, a hundred times
# run and freed; a thousand times loaded and unloaded, from one file and from as many copies; how
# deep their calls go; the same numbers on Windows under wine and on ARM64 under qemu. Also their
# size, what they need, and that no path of this machine is inside. Then the static library: a race
# with the bits of the FMU's, its example under Valgrind. Arguments: FMUs (default out/fmu).
set -eu
cd "$(dirname "$0")/.."
fmus=${1:-out/fmu}
target=${CARGO_TARGET_DIR:-target}
lib=$target/fmu/lib
work=$target/fmu/host
mkdir -p "$work"

fail() { echo "$*" >&2; exit 1; }
for tool in gcc:gcc x86_64-w64-mingw32-gcc:gcc-mingw-w64-x86-64 qemu-aarch64:qemu-user \
    aarch64-linux-gnu-gcc:gcc-aarch64-linux-gnu valgrind:valgrind unzip:unzip strings:binutils; do
    command -v "${tool%%:*}" >/dev/null ||
        fail "${tool%%:*} is missing: apt-get install ${tool#*:}, or tools/setup.sh fmu fmu-test"
done

gcc -O1 -Wall -Wno-unused-variable -o "$work/host" fmu/tests/host/host.c -ldl
gcc -O1 -Wall -o "$work/load" fmu/tests/host/load.c -ldl -pthread
aarch64-linux-gnu-gcc -O1 -Wno-unused-variable -o "$work/host-arm64" fmu/tests/host/host.c -ldl
x86_64-w64-mingw32-gcc -O1 -o "$work/host.exe" fmu/tests/host/host.c
x86_64-w64-mingw32-gcc -shared -o "$work/bcryptprimitives.dll" fmu/tests/host/process_prng.c -ladvapi32
wine=$(command -v wine64 || command -v wine || echo /usr/lib/wine/wine64)
export WINEDEBUG=-all WINEPREFIX="$PWD/$work/wine"
case $work in /*) WINEPREFIX=$work/wine ;; esac

small() { # library: below 4.5 MiB, no path of this machine
    [ "$(stat -c %s "$1")" -lt 4718592 ] || fail "$1: $(stat -c %s "$1") bytes, more than 4.5 MiB"
    if strings -a "$1" | grep -F -e "$PWD" -e "$HOME/"; then fail "$1: a path of this machine"; fi
}

for name in vehicle controller; do
    xml=$(unzip -p "$fmus/fmi2/lmpc-$name.fmu" modelDescription.xml)
    token=$(echo "$xml" | grep -o ' guid="[^"]*"' | cut -d'"' -f2)
    [ $name = vehicle ] && output=truth.e_y || output=status.steps
    reference=$(echo "$xml" | grep -o "name=\"$output\" valueReference=\"[0-9]*\"" |
        grep -o '[0-9]*"$' | tr -d '"')
    so=$lib/x86_64-unknown-linux-gnu/liblmpc_$name.so
    arm=$lib/aarch64-unknown-linux-gnu/liblmpc_$name.so
    dll=$lib/x86_64-pc-windows-gnu/lmpc_$name.dll
    for file in "$so" "$arm" "$dll"; do small "$file"; done
    unzip -l "$fmus/fmi3/lmpc-$name.fmu" | grep -q "binaries/aarch64-linux/lmpc_$name.so" ||
        fail "$fmus/fmi3/lmpc-$name.fmu: no library for ARM"

    native=$("$work/host" "$so" "$token" 1 100 "$reference")
    cp "$dll" "$work/"
    windows=$(cd "$work" && "$wine" host.exe "lmpc_$name.dll" "$token" 1 100 "$reference" | tr -d '\r')
    [ "$native" = "$windows" ] || fail "$name: Linux $native, Windows $windows"
    found=$(qemu-aarch64 -L /usr/aarch64-linux-gnu "$work/host-arm64" "$arm" "$token" 2 100 "$reference")
    [ "$native" = "$found" ] || fail "$name: x64 $native, ARM $found"
    valgrind --quiet --leak-check=full --errors-for-leak-kinds=definite,indirect --error-exitcode=9 \
        "$work/host" "$so" "$token" 100 20 "$reference" > /dev/null
    echo "$name: $(stat -c %s "$so"), $(stat -c %s "$arm") and $(stat -c %s "$dll") bytes; FMI 2 and" \
        "3 after 100 steps: $native, the same on ARM and under wine; no leak in 100 cycles"

    one=$("$work/load" "$so" "$token" same 1000)
    many=$("$work/load" "$so" "$token" copies 1000)
    for grown in "$one" "$many"; do
        [ "$grown" -lt 100 ] || fail "$name: $grown kB more with each of 1000 loads"
    done
    stack=$("$work/load" "$so" "$token" stack 100)
    for number in $stack; do
        case $number in
            [0-9]*) [ "$number" -lt 65536 ] || fail "$name: too deep a stack: $stack" ;;
        esac
    done
    echo "$name: 1000 times loaded, $one kB each from one file, $many kB from copies; stack: $stack bytes"
done

# shellcheck disable=SC2086 # one word per argument
static() { # program, source, flags
    gcc -O1 -Wall -Wextra $3 -Ifmu/capi -o "$work/$1" "$2" -L"$lib/x86_64-unknown-linux-gnu" \
        -llmpc_c -lgcc_eh -lpthread -ldl -lm
}
gcc -O1 -w -o "$work/race" fmu/tests/host/race.c -ldl -lpthread
static race-static fmu/tests/host/race.c "-DSTATIC_CONTROLLER -w"
static example fmu/capi/example.c ""
tools/fmu_references.sh "$fmus" > "$work/references"
so=$lib/x86_64-unknown-linux-gnu
race() { "$work/$1" "$2" "$so/liblmpc_vehicle.so" "$work/references" 2 400 "$3" 0; }
expected=$(race race "$so/liblmpc_controller.so" nearest)
for state in nearest up trap flush; do
    found=$(race race-static - $state)
    [ "$found" = "$expected" ] || fail "static library, host's state $state: $found, FMU: $expected"
done
# Valgrind (3.19) does not know one form of `vmovq`, which the compiler chooses in code for AVX2. It
# runs a copy that takes the processor for one without AVX2: the byte in which pulp keeps the answer
# is 0 (no) from the start, instead of 255 (not asked yet). The copy prints what the original does.
plain=$work/example-plain
cp "$work/example" "$plain"
address=$(nm "$plain" | sed -n 's/ D .*v32V3.*__static_available9AVAILABLE.*//p')
[ -n "$address" ] || fail "static library: pulp's answer on AVX2 is not found"
section=$(objdump -h "$plain" | awk '$2 == ".data" { print "0x" $4, "0x" $6 }')
offset=$((0x$address - ${section% *} + ${section#* }))
[ "$(od -An -tu1 -j $offset -N 1 "$plain" | tr -d ' ')" = 255 ] ||
    fail "static library: pulp's answer on AVX2 is not 255 at first"
printf '\0' | dd of="$plain" bs=1 seek=$offset conv=notrunc status=none
"$work/example" > "$work/example.txt"
valgrind --quiet --leak-check=full --errors-for-leak-kinds=definite,indirect --error-exitcode=9 \
    "$plain" > "$work/example-plain.txt"
cmp "$work/example.txt" "$work/example-plain.txt"
echo "static library: $expected (hash, learned steps, laps of 400 steps), as the FMU; no leak"
