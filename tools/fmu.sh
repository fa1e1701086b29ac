#!/bin/sh
# Builds the FMUs' shared libraries into target/fmu: stripped, without paths of this machine, and
# on Linux with libgcc inside, so that libc and libm are all they need.
# Targets are arguments; default: this machine's Linux and, if --windows is given, Windows x64.
set -eu
cd "$(dirname "$0")/.."

targets="x86_64-unknown-linux-gnu"
[ "${1:-}" = "--windows" ] && targets="$targets x86_64-pc-windows-gnu"
[ "${1:-}" = "--arm64" ] && targets="aarch64-unknown-linux-gnu"

cargo_home=${CARGO_HOME:-$HOME/.cargo}
sysroot=$(rustc --print sysroot)
out=${CARGO_TARGET_DIR:-target}/fmu
remap="--remap-path-prefix=$PWD=lmpc --remap-path-prefix=$cargo_home=cargo"
remap="$remap --remap-path-prefix=$sysroot=rust"

# The standard library asks for libgcc_s; this linker script answers with the static parts.
mkdir -p "$out/libgcc"
echo "GROUP ( -lgcc_eh -lgcc )" > "$out/libgcc/libgcc_s.so"
out=$(cd "$out" && pwd)

for target in $targets; do
    flags="$remap"
    case $target in *linux*) flags="$flags -L native=$out/libgcc" ;; esac
    [ "$target" = aarch64-unknown-linux-gnu ] &&
        flags="$flags -C linker=${CROSS_CC:-aarch64-linux-gnu-gcc}"
    # Without sections of their own, dead functions leave a DLL only at link-time optimisation.
    lto=false
    case $target in *windows*) lto=thin ;; esac
    CARGO_PROFILE_FMU_LTO=$lto RUSTFLAGS="$flags" cargo build --quiet --profile fmu --target "$target" \
        --target-dir "$out/build" -p lmpc_vehicle -p lmpc_controller
    mkdir -p "$out/lib/$target"
    for name in lmpc_vehicle lmpc_controller; do
        for file in "lib$name.so" "$name.dll"; do
            built="$out/build/$target/fmu/$file"
            [ ! -f "$built" ] || cp "$built" "$out/lib/$target/"
        done
    done
done
