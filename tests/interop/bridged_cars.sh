#!/bin/sh
# `lmpc bridge` before cars that are not the simulated one, in a network namespace of its own: a
# lap behind the grant, then the controller is killed and the car has to stand on the track.
#     tests/interop/bridged_cars.sh car             a car with messages of its own, by its map
#     tests/interop/bridged_cars.sh fmu:FILE        our vehicle FMU
#     tests/interop/bridged_cars.sh fmu:FILE MAP    another tool's, by its map
set -eu
cd "$(dirname "$0")/../.."
tests/interop/needs.sh target/lcm/venv/bin/python
vehicle=${1:-car}
out=target/lcm/bridged
python=target/lcm/venv/bin/python
lmpc=target/release/lmpc
if [ -z "${LMPC_ISOLATED:-}" ]; then
    tools/build.sh --quiet
    LMPC_ISOLATED=1 exec tests/interop/isolated.sh timeout 300 "$0" "$@"
fi
rm -rf "$out" && mkdir -p "$out"
export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0'
pids=
trap 'kill $pids 2>/dev/null || true' EXIT
if [ "$vehicle" = car ]; then
    $lmpc bridge --set warm_up.laps=2 --vehicle car --map examples/lcm/car.toml --state-period-ms 20 2>"$out/bridge.txt" &
    bridge=$!
    "$python" examples/lcm/foreign_car.py --rate 50 --distance 1000 --patience 240 &
    pids="$bridge $!"
else
    $lmpc bridge --set warm_up.laps=2 --vehicle "$vehicle" ${2:+--map "$2"} 2>"$out/bridge.txt" &
    bridge=$!
    pids=$bridge
fi
$lmpc serve --set warm_up.laps=2 2>"$out/serve.txt" &
serve=$!
pids="$pids $serve"

now() { # a field of `lmpc top --json`, as Python has it
    $lmpc top --json --listen "${2:-0.3}" | "$python" -c "
import json, sys
seen = json.load(sys.stdin)
program = {p['name']: p for p in seen['programs']}
print($1)"
}
until_true() { # for a minute
    for _ in $(seq 150); do
        [ "$(now "$1")" = True ] && return
    done
    echo "never: $1" >&2
    cat "$out"/*.txt >&2
    return 1
}
until_obeyed() {
    for _ in $(seq 60); do
        $lmpc operator "$@" 2>"$out/operator.txt" && return
        sleep 0.2
    done
    cat "$out/operator.txt" >&2
    return 1
}
until_obeyed arm
until_obeyed start
until_true "program['bridge']['state'] == 'RUNNING' and seen['car']['v_x_mps'] > 0.5"
# Past the line, where the controller closes its first lap.
for _ in $(seq 200); do
    grep -q '^lap' "$out/serve.txt" && break
    sleep 0.2
done
grep '^lap' "$out/serve.txt"
$lmpc top --once --listen 0.5
kill -9 $serve
until_true "program['bridge']['state'] == 'IDLE' and abs(seen['car']['v_x_mps']) < 0.1"
until_true "seen['last_stop'] in ('no valid command in time', \"the last command's validity ended\")"
# Another start of the controller, without a grant: it only tells where the track is.
$lmpc serve --dry-run 2>/dev/null &
pids="$pids $!"
until_true "seen['track'] is not None"
# It still stands seconds later: the brake that holds it must not drive it backwards.
sleep 3
[ "$(now "abs(seen['car']['v_x_mps']) < 0.1
    and -seen['car']['width_m'][1] < seen['car']['e_y_m'] < seen['car']['width_m'][0]" 1.5)" = True ]
echo "stands at s $(now "round(seen['car']['s_m'], 2)" 1.5), e_y $(now "round(seen['car']['e_y_m'], 3)" 1.5) m"
kill -INT $bridge
wait $bridge
tail -1 "$out/bridge.txt"
