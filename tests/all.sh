#!/bin/sh
# Every test: what `make test` runs. With the argument `lints` first what `.ci/run` adds to it.
set -eu
cd "$(dirname "$0")/.."
. tests/steps.sh

step tools/setup.sh race test fmu fmu-test
beside sh -c 'tools/setup-lcm.sh && tools/fmu_tools.sh zig python && tools/fmu_tools.sh'
if [ "${1:-}" = lints ]; then
    step cargo fmt --check
    # It compiles what the tests do.
    step cargo clippy --workspace --all-targets --release -- -D warnings
fi
step cargo test --workspace --release --no-run
joined
step tools/build.sh
export LMPC_BUILT=1

step cargo test --workspace --release
step tests/interop/types.sh
step tests/interop/python_vehicle.sh
step tests/interop/mapped_car.sh
step tests/interop/bridged_cars.sh car
step tests/interop/export.sh
step tests/interop/closed_loop.sh
step tests/interop/spy.sh
step tests/interop/slurm.sh
step tests/interop/view.sh
step tests/interop/vehicles.sh
step env LMPC_DEB_BINARY="${CARGO_TARGET_DIR:-target}/release/lmpc" tools/deb.sh
step env LMPC_DEB_MOST=24000000 tests/interop/deb.sh
step tools/pack_fmus.sh
step tests/fmus.sh
step python/test.sh
