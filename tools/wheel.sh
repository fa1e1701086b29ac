#!/bin/sh
# Builds the wheels of the Python package for x64 and ARM64 into out/wheels: glibc 2.17 or newer, Python
# 3.9 or newer. Architectures are arguments: x86_64, aarch64.
set -eu
cd "$(dirname "$0")/.."
. tools/zig.sh
tools/fmu_tools.sh python
tools/wheel_fmus.sh
maturin=$(cd "${CARGO_TARGET_DIR:-target}/tools/python/bin" && pwd)/maturin

cargo_home=${CARGO_HOME:-$HOME/.cargo}
remap="--remap-path-prefix=$PWD=lmpc --remap-path-prefix=$cargo_home=cargo"
remap="$remap --remap-path-prefix=$(rustc --print sysroot)=rust"
target=$(mkdir -p "${CARGO_TARGET_DIR:-target}/zig" && cd "${CARGO_TARGET_DIR:-target}/zig" && pwd)
looked=$(mktemp -d)
trap 'rm -rf "$looked"' EXIT

for machine in ${*:-x86_64 aarch64}; do
    tag=manylinux_$(echo "$GLIBC" | tr . _)
    RUSTFLAGS="$remap" "$maturin" build --quiet --locked --release --zig \
        --compatibility "$tag" --target "$machine-unknown-linux-gnu" --target-dir "$target" \
        --manifest-path python/Cargo.toml --out out/wheels
    for wheel in out/wheels/*"$machine".whl; do
        python3 -m zipfile -e "$wheel" "$looked/$machine"
    done
    tools/glibc_floor.sh "$GLIBC" "$looked/$machine"/racing_lmpc/*.so
    [ "$(find "$looked/$machine/racing_lmpc/fmu_files" -name "*.fmu" | wc -l)" = 4 ] ||
        { echo "the wheel for $machine has no four FMUs" >&2; exit 1; }
done
