#!/bin/sh
# A car with messages of its own drives with `lmpc serve` through `lmpc vehicle car --map`, in a
# network namespace of its own; when the commands stop, it gets the order to brake.
set -eu
cd "$(dirname "$0")/../.."
tests/interop/needs.sh target/lcm/venv/bin/python
out=target/lcm/mapped
python=target/lcm/venv/bin/python
if [ -z "${LMPC_ISOLATED:-}" ]; then
    tools/build.sh --quiet
    LMPC_ISOLATED=1 exec tests/interop/isolated.sh timeout 300 "$0" "$@"
fi
rm -rf "$out" && mkdir -p "$out"
export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0'
target/release/lmpc check examples/lcm/car.toml
target/release/lmpc record "$out/drive.log" 2>/dev/null &
record=$!
target/release/lmpc vehicle car --map examples/lcm/car.toml &
bridge=$!
target/release/lmpc serve --set warm_up.laps=2 2>"$out/serve.txt" &
serve=$!
trap 'kill $serve $bridge $record 2>/dev/null || true' EXIT
"$python" examples/lcm/foreign_car.py --distance 88 --then-stop
laps=$(grep -c '^lap' "$out/serve.txt")
cat "$out/serve.txt"
[ "$laps" -ge 5 ]
! grep -q 'not valid' "$out/serve.txt"
kill -INT $serve $bridge
wait $serve $bridge
kill -INT $record
wait $record
