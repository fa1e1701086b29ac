#!/bin/sh
# The control loop at 100 Hz on a busy machine: `lmpc serve` and `lmpc vehicle sim` in two processes
# beside two busy loops per processor, first with FIFO priority, then without.
#
#   tests/interop/realtime.sh [SECONDS]
#
# Beside the drive with FIFO, cyclictest wakes an idle thread of higher priority on every processor: how
# late that is, the machine is by itself (a virtual machine's host takes its processors away), and no
# program on it can be earlier. Fails if with FIFO a command comes later than a period after its state,
# or a period of the car begins more than a period later than the machine's own worst wake-up.
# Without FIFO the misses are only shown: in the heartbeats, which are read from a recording, and at
# the end of each program. Needs root.
set -eu
cd "$(dirname "$0")/../.."
tests/interop/needs.sh strings cyclictest
seconds=${1:-60}
out=target/lcm/realtime
if [ -z "${LMPC_ISOLATED:-}" ]; then
    tools/build.sh --quiet
    LMPC_ISOLATED=1 exec tests/interop/isolated.sh --fifo timeout 600 "$0" "$@"
fi
rm -rf "$out" && mkdir -p "$out"
export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304'
busy=
for _ in $(seq $((2 * $(nproc)))); do
    sh -c 'while :; do :; done' &
    busy="$busy $!"
done
trap 'kill $busy 2>/dev/null || true' EXIT

drive() { # drive NAME SECONDS OPTION...
    name=$1
    steps=$(($2 * 100))
    shift 2
    target/release/lmpc record "$out/$name.log" 2>/dev/null &
    record=$!
    target/release/lmpc serve --config config/barc_100hz.toml "$@" 2>"$out/$name-serve.txt" &
    serve=$!
    sleep 1
    target/release/lmpc vehicle sim --config config/barc_100hz.toml --start-speed 1 \
        --steps "$steps" "$@" 2>"$out/$name-sim.txt" || true
    kill -INT $serve
    wait $serve
    kill -INT $record
    wait $record || true
    echo "$name, car:     $(grep periods "$out/$name-sim.txt")"
    echo "$name, service: $(grep 'longer than a period' "$out/$name-serve.txt")"
    echo "$name, heartbeat: $(strings "$out/$name.log" | grep -o '[0-9]* steps took longer.*' | tail -1)"
}
cyclictest --priority 99 --mlockall --threads --affinity --interval 2000 --duration "$seconds" --quiet >"$out/machine.txt" &
machine=$!
drive fifo "$seconds" --realtime
wait $machine
own=$(sed -n 's/.*Max: *//p' "$out/machine.txt" | sort -n | tail -1)
echo "fifo, the machine by itself: latest wake-up of an idle thread of priority 99: $own us"
drive normal 20
if grep 'no FIFO' "$out/fifo-serve.txt"; then
    exit 1
fi
grep -q ', 0 longer than a period' "$out/fifo-serve.txt"
late=$(sed -n 's/.*periods.*latest by \([0-9.]*\) ms.*/\1/p' "$out/fifo-sim.txt")
awk -v late="$late" -v own="$own" 'BEGIN { exit !(late != "" && own != "" && late <= 10 + own / 1000) }'
grep -q 'without real-time priority' "$out/normal-serve.txt"
