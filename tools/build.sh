#!/bin/sh
# Builds `lmpc` and the examples that the scripts run, with the features `cargo test --workspace` gives their
# dependencies: Cargo chooses features by what is built together, so a package built by itself would compile
# most of it a second time. Arguments go to cargo. Where LMPC_BUILT is set, all of it is built already.
set -eu
cd "$(dirname "$0")/.."
[ -z "${LMPC_BUILT:-}" ] || exit 0
cargo build --locked --release --workspace --bin lmpc --example wire --example lcm_traffic --example lcm_load \
    --example packed_fmus "$@"
