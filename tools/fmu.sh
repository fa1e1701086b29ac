#!/bin/sh
# Builds the FMUs' shared libraries, and the controller as a static library with its header, into
# target/fmu/lib: stripped, without paths of this machine,
# and on Linux for glibc 2.17 (2012), with libc and its parts as all they need.
# Targets are arguments: x64, arm64, windows; default: all three.
set -eu
cd "$(dirname "$0")/.."
. tools/zig.sh

cargo_home=${CARGO_HOME:-$HOME/.cargo}
sysroot=$(rustc --print sysroot)
out=${CARGO_TARGET_DIR:-target}/fmu
remap="--remap-path-prefix=$PWD=lmpc --remap-path-prefix=$cargo_home=cargo"
remap="$remap --remap-path-prefix=$sysroot=rust"
mkdir -p "$out"
out=$(cd "$out" && pwd)

build() { # target, cargo's subcommand and its target, link-time optimisation
    CARGO_PROFILE_FMU_LTO=$4 RUSTFLAGS="$remap" cargo "$2" --quiet --profile fmu --target "$3" \
        --target-dir "$out/build" -p lmpc_vehicle -p lmpc_controller -p lmpc_c
    mkdir -p "$out/lib/$1"
    for name in lmpc_vehicle lmpc_controller; do
        for file in "lib$name.so" "$name.dll"; do
            built="$out/build/$1/fmu/$file"
            [ ! -f "$built" ] || cp "$built" "$out/lib/$1/"
        done
    done
    cp "$out/build/$1/fmu/liblmpc_c.a" fmu/capi/lmpc.h "$out/lib/$1/"
}

for platform in ${*:-x64 arm64 windows}; do
    case $platform in
        x64) build x86_64-unknown-linux-gnu zigbuild "x86_64-unknown-linux-gnu.$GLIBC" false ;;
        arm64) build aarch64-unknown-linux-gnu zigbuild "aarch64-unknown-linux-gnu.$GLIBC" false ;;
        # Without sections of their own, dead functions leave a DLL only at link-time optimisation.
        windows) build x86_64-pc-windows-gnu build x86_64-pc-windows-gnu thin ;;
        *) echo "unknown platform '$platform'; expected x64, arm64 or windows" >&2 && exit 2 ;;
    esac
done

set -- "$out"/lib/*-linux-gnu/*.so
[ ! -e "$1" ] || tools/glibc_floor.sh "$GLIBC" "$@"
