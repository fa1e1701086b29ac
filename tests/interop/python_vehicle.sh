#!/bin/sh
# A vehicle in Python drives five laps with `lmpc serve`, in a network namespace of its own.
set -eu
cd "$(dirname "$0")/../.."
tests/interop/needs.sh target/lcm/venv/bin/python
if [ -z "${LMPC_ISOLATED:-}" ]; then
    tools/build.sh --quiet
    LMPC_ISOLATED=1 exec tests/interop/isolated.sh timeout 300 "$0" "$@"
fi
export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0'
target/release/lmpc serve --set warm_up.laps=2 &
serve=$!
trap 'kill $serve 2>/dev/null || true' EXIT
target/lcm/venv/bin/python examples/lcm/python_vehicle.py --laps 5
