#!/bin/sh
# Builds the Python package, installs it into a venv of its own and runs its tests. They need the FMUs of
# `make fmu`.
# `tools/setup.sh race test` installs what the system lacks for it. Arguments go to pytest.
set -eu
cd "$(dirname "$0")/.."
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
tools/fmu_tools.sh python
bin=$target/tools/python/bin
wheels=$target/python
rm -rf "$wheels"
tools/wheel_fmus.sh
PATH=$bin:$PATH maturin build --quiet --locked --release --compatibility linux \
    --manifest-path python/Cargo.toml --interpreter "$bin/python" --out "$wheels"
"$bin/pip" install --quiet --disable-pip-version-check --no-deps --force-reinstall "$wheels"/*.whl
tools/build.sh --quiet
cd python
LMPC=$target/release/lmpc "$bin/pytest" -q -p no:cacheprovider "$@"
