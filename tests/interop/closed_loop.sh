#!/bin/sh
# `lmpc serve` and `lmpc vehicle sim` drive learning laps over real UDP multicast in real time, 10 Hz,
# in a network namespace of their own; lcm-logger records beside them, Python decodes every message,
# and `lmpc replay` of the recording gives the same commands again.
#
#   tests/interop/closed_loop.sh [LAPS]
#
# Fails if a lap leaves the track, a message cannot be decoded, or a command comes out otherwise.
set -eu
cd "$(dirname "$0")/../.."
tests/interop/needs.sh lcm-logger target/lcm/venv/bin/python
laps=${1:-8}
out=target/lcm/closed_loop
types=target/lcm/types/pypi
if [ -z "${LMPC_ISOLATED:-}" ]; then
    tools/build.sh --quiet
    tests/interop/python_types.sh "$types"
    LMPC_ISOLATED=1 exec tests/interop/isolated.sh timeout 600 "$0" "$@"
fi
rm -rf "$out" && mkdir -p "$out"
export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304'
lcm-logger "$out/drive.log" >"$out/logger.txt" 2>&1 &
logger=$!
target/release/lmpc serve --set warm_up.laps=2 --learned "$out/learned.lmpc" 2>"$out/serve.txt" &
serve=$!
trap 'kill $serve $logger 2>/dev/null || true' EXIT
sleep 1
target/release/lmpc vehicle sim --laps "$laps" 2>"$out/sim.txt" || { cat "$out/sim.txt"; exit 1; }
kill -INT $serve
wait $serve
kill -INT $logger
wait $logger || true
cat "$out/sim.txt" "$out/serve.txt"
target/lcm/venv/bin/python tests/interop/decode_log.py "$types" "$out/drive.log" "$laps"
target/release/lmpc replay "$out/drive.log" --set warm_up.laps=2
