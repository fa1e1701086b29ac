#!/bin/sh
# Our message types against the official generators and the official Python package:
# fingerprints of lcm-gen 1.3.1 (Debian) and 1.5.3 (PyPI), and random messages
# Rust -> Python -> Rust, which must come back byte for byte.
#
#   tests/interop/types.sh [COUNT] [SEED]
set -eu
cd "$(dirname "$0")/../.."
tests/interop/needs.sh lcm-gen target/lcm/venv/bin/python
count=${1:-50000}
seed=${2:-1}
out=target/lcm/types
python=target/lcm/venv/bin/python
packaged=$(dirname "$("$python" -c 'import lcm; print(lcm.__file__)')")/../bin/lcm-gen
files="lcm_types/lcm/*.lcm lcm_types/tests/lcm/*.lcm"

tools/build.sh --quiet
wire=target/release/examples/wire
rm -rf "$out"
mkdir -p "$out/debian" "$out/pypi"
lcm-gen --python --ppath "$out/debian" $files
"$packaged" --python --ppath "$out/pypi" $files

"$wire" hashes $files >"$out/rust.txt"
for generator in debian pypi; do
    "$python" tests/interop/hashes.py "$out/$generator" >"$out/$generator.txt"
    diff "$out/rust.txt" "$out/$generator.txt"
    echo "fingerprints: $(wc -l <"$out/rust.txt") types equal to lcm-gen ($generator)"
done

# The Python of Debian's lcm-gen cannot re-encode arrays of booleans; PyPI's can.
"$wire" emit "$count" "$seed" $files |
    "$python" tests/interop/echo.py "$out/pypi" |
    "$wire" check "$count" "$seed" $files
"$python" tests/interop/golden.py "$out/pypi" lcm_types/golden --compare
