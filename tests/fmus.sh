#!/bin/sh
# Both FMUs of `make fmu` in every importer that is not ours, under Valgrind, wine and qemu, and as the car
# behind the bridge.
set -eu
cd "$(dirname "$0")/.."
. tests/steps.sh
step tools/fmu_check.sh
step tools/fmu_host_check.sh
step tests/interop/bridged_cars.sh fmu:out/fmu/fmi3/lmpc-vehicle.fmu
step tests/interop/bridged_cars.sh "fmu:${CARGO_TARGET_DIR:-target}/fmu/check/foreign/DegreesVehicle.fmu" \
    examples/fmu/degrees_map.toml
