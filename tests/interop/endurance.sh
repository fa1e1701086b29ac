#!/bin/sh
# Racing in real time for an hour, measured with noise: `lmpc serve` through `lmpc bridge`, recorded by `lmpc record`.
#
#   tests/interop/endurance.sh [SECONDS] [LMPC]
#
# Every ten seconds the resident memory of the three goes to target/lcm/endurance/memory.csv. A stopped
# car is armed again and the stop counted. Fails if one of them grows by more than 5 MB after the first
# sixth of the time, if a lap left the track, or if a program ended by itself. Needs root, for FIFO priority.
set -eu
cd "$(dirname "$0")/../.."
tests/interop/needs.sh awk
seconds=${1:-3600}
lmpc=${2:-target/release/lmpc}
out=target/lcm/endurance
if [ -z "${LMPC_ISOLATED:-}" ]; then
    [ -n "${2:-}" ] || tools/build.sh --quiet
    LMPC_ISOLATED=1 exec tests/interop/isolated.sh --fifo "$0" "$@"
fi
rm -rf "$out" && mkdir -p "$out"
export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304'
"$lmpc" record "$out/drive.log" 2>"$out/record.txt" &
record=$!
"$lmpc" bridge --realtime --plant noise=0.001 2>"$out/bridge.txt" &
bridge=$!
"$lmpc" serve --realtime --learned "$out/learned.lmpc" 2>"$out/serve.txt" &
serve=$!
trap 'kill $record $bridge $serve 2>/dev/null || true' EXIT
sleep 2

memory() { awk '/^VmRSS/ { printf "%.3f", $2 / 1024 }' "/proc/$1/status"; }

echo 'time_s,serve_mb,bridge_mb,record_mb,learned_bytes,log_bytes' >"$out/memory.csv"
begun=$(date +%s)
armed=0
while now=$(($(date +%s) - begun)) && [ "$now" -lt "$seconds" ]; do
    for id in $record $bridge $serve; do
        kill -0 "$id" 2>/dev/null || { echo "a program ended by itself after $now s" >&2; tail -n 2 "$out"/*.txt >&2; exit 1; }
    done
    if "$lmpc" operator arm >/dev/null 2>&1 && "$lmpc" operator start >/dev/null 2>&1; then
        armed=$((armed + 1))
        echo "armed after $now s" >>"$out/armed.txt"
    fi
    size() { stat -c %s "$1" 2>/dev/null || echo 0; }
    echo "$now,$(memory $serve),$(memory $bridge),$(memory $record),$(size "$out/learned.lmpc"),$(size "$out/drive.log")" >>"$out/memory.csv"
    sleep 10
done
kill -INT $serve && wait $serve
kill -INT $bridge && wait $bridge || true
kill -INT $record && wait $record || true
trap - EXIT
tail -n 3 "$out/serve.txt" "$out/bridge.txt" "$out/record.txt"
awk -F, -v after=$((seconds / 6)) -v armed="$armed" '
    NR > 1 && $1 >= after { for (i = 2; i <= 4; i++) { if (!(i in low)) low[i] = high[i] = $i; if ($i > high[i]) high[i] = $i }; last = $0 }
    END {
        split("serve bridge record", name, " ")
        print "armed " armed " times (1: never stopped)"
        for (i = 2; i <= 4; i++) {
            printf "%s: %.2f MB after the first sixth, at most %.2f MB later\n", name[i - 1], low[i], high[i]
            bad = bad || high[i] - low[i] > 5
        }
        split(last, l, ","); printf "learned data %d bytes, log %d bytes\n", l[5], l[6]
        exit bad
    }' "$out/memory.csv"
off=$(grep -c 'not valid' "$out/serve.txt" || true)
echo "$off laps not valid (1: the first begins off the line)"
[ "$off" -le 1 ]
