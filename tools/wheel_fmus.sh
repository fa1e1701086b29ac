#!/bin/sh
# Puts the FMUs of `make fmu` where the Python package takes them into its wheel.
set -eu
cd "$(dirname "$0")/.."
packed=python/racing_lmpc/fmu_files
for version in 2 3; do
    mkdir -p "$packed/fmi$version"
    for name in controller vehicle; do
        cp "out/fmu/fmi$version/lmpc-$name.fmu" "$packed/fmi$version/" ||
            { echo "the wheel has the FMUs inside: make fmu" >&2; exit 1; }
    done
done
