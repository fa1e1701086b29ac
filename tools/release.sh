#!/bin/sh
# Builds the program for other Linux machines, x64 and ARM64, into out/release: glibc 2.17 or newer,
# and nothing but libc needed to start. Architectures are arguments: x86_64, aarch64. LMPC_FEATURES=foxglove
# adds the server of `lmpc view --foxglove`.
set -eu
cd "$(dirname "$0")/.."
. tools/zig.sh

cargo_home=${CARGO_HOME:-$HOME/.cargo}
remap="--remap-path-prefix=$PWD=lmpc --remap-path-prefix=$cargo_home=cargo"
remap="$remap --remap-path-prefix=$(rustc --print sysroot)=rust"
target=$(mkdir -p "${CARGO_TARGET_DIR:-target}/zig" && cd "${CARGO_TARGET_DIR:-target}/zig" && pwd)

for machine in ${*:-x86_64 aarch64}; do
    RUSTFLAGS="$remap" CARGO_PROFILE_RELEASE_DEBUG=false CARGO_PROFILE_RELEASE_STRIP=symbols \
        cargo zigbuild --quiet --release --target "$machine-unknown-linux-gnu.$GLIBC" \
        --target-dir "$target" -p vehicle_bridge --bin lmpc ${LMPC_FEATURES:+--features "$LMPC_FEATURES"}
    mkdir -p "out/release/$machine"
    cp "$target/$machine-unknown-linux-gnu/release/lmpc" "out/release/$machine/lmpc"
    tools/glibc_floor.sh "$GLIBC" "out/release/$machine/lmpc"
done
