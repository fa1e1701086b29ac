#!/bin/sh
# Python classes of our messages, by the official generator of the PyPI package, in the folder named.
#
#   tests/interop/python_types.sh FOLDER
set -eu
python=target/lcm/venv/bin/python
tests/interop/needs.sh "$python"
generator=$(dirname "$("$python" -c 'import lcm; print(lcm.__file__)')")/../bin/lcm-gen
mkdir -p "$1"
"$generator" --python --ppath "$1" lcm_types/lcm/*.lcm
