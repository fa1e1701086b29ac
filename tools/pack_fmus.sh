#!/bin/sh
# Both FMUs for every platform, FMI 2.0 and 3.0, and the wired systems, in out/fmu.
set -eu
cd "$(dirname "$0")/.."
target=${CARGO_TARGET_DIR:-target}
tools/fmu.sh
tools/build.sh --quiet
"$target/release/lmpc" fmu pack "$target/fmu/lib" --out out/fmu
