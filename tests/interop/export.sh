#!/bin/sh
# Laps driven in lock-step, recorded by lcm-logger and by `lmpc record`, in a network namespace of
# their own; `lmpc export` of both logs holds what Python decodes from them, by the official `mcap`.
set -eu
cd "$(dirname "$0")/../.."
tests/interop/needs.sh lcm-logger target/lcm/venv/bin/python
out=target/lcm/export
types=target/lcm/types/pypi
python=target/lcm/venv/bin/python
if [ -z "${LMPC_ISOLATED:-}" ]; then
    tools/build.sh --quiet
    tests/interop/python_types.sh "$types"
    LMPC_ISOLATED=1 exec tests/interop/isolated.sh timeout 300 "$0" "$@"
fi
rm -rf "$out" && mkdir -p "$out"
export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304'
lcm-logger "$out/logger.log" >"$out/logger.txt" 2>&1 &
logger=$!
target/release/lmpc record "$out/record.log" 2>"$out/record.txt" &
record=$!
sleep 1
target/release/lmpc serve --set warm_up.laps=1 2>"$out/serve.txt" &
serve=$!
trap 'kill $serve $record $logger 2>/dev/null || true' EXIT
target/release/lmpc vehicle sim --lock-step --laps 3 2>"$out/sim.txt" || { cat "$out/sim.txt"; exit 1; }
sleep 1
kill -INT $serve
wait $serve
kill -INT $record $logger
wait $record
wait $logger || true
for log in logger record; do
    target/release/lmpc export "$out/$log.log" --csv "$out/$log" --mcap "$out/$log.mcap"
    "$python" tests/interop/check_export.py "$types" "$out/$log.log" "$out/$log.mcap" "$out/$log"
done
