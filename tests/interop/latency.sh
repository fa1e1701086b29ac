#!/bin/sh
# Latency and loss of the Rust transport beside C liblcm, in one run and interleaved.
#
#   tests/interop/latency.sh [ROUNDS] [--gate]
#
# With --gate it fails if the median p50 of the Rust handler is above 0.6 of C's, or if a message is
# lost at 20,000 per second. Figures depend on the machine: read them as ratios.
set -eu
cd "$(dirname "$0")/../.."
tests/interop/needs.sh cc
rounds=${1:-3}
gate=${2:-}
out=target/lcm/latency
url='udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304'
if [ -z "${LMPC_ISOLATED:-}" ]; then
    mkdir -p "$out"
    cc -O2 -o "$out/lcm_load" tests/interop/lcm_load.c -llcm
    tools/build.sh --quiet
    LMPC_ISOLATED=1 exec tests/interop/isolated.sh "$0" "$@"
fi
export LCM_DEFAULT_URL="$url"

measure() { # measure NAME SUBSCRIBER PUBLISHER URL COUNT RATE
    LCM_LOAD_URL=$4 $2 >"$out/line" &
    subscriber=$!
    sleep 0.3
    LCM_LOAD_URL=$4 $3 pub "$5" "$6" 1024
    wait "$subscriber"
    printf '%-28s %6s/s  %s\n' "$1" "$6" "$(cat "$out/line")" | tee -a "$out/table"
}

c=$out/lcm_load
rust=target/release/examples/lcm_load
: >"$out/table"
echo 'publisher -> subscriber           rate  received lost p50 p99 max [us]'
for round in $(seq "$rounds"); do
    measure c "$c sub" "$c" "$url" 3000 500
    measure rust-handler "$rust sub" "$rust" "$url" 3000 500
    measure rust-inbox "$rust inbox" "$rust" "$url" 3000 500
    measure rust-through-liblcm "$rust sub" "$rust" "liblcm+$url" 3000 500
done
for round in $(seq "$rounds"); do
    measure c "$c sub" "$c" "$url" 40000 20000
    measure rust-handler "$rust sub" "$rust" "$url" 40000 20000
    measure rust-inbox "$rust inbox" "$rust" "$url" 40000 20000
done

median() { # median NAME RATE COLUMN
    awk -v n="$1" -v r="$2/s" -v c="$3" '$1 == n && $2 == r { print $c }' "$out/table" |
        sort -n | awk '{ v[NR] = $1 } END { print v[int((NR + 1) / 2)] }'
}
for name in rust-handler rust-inbox rust-through-liblcm; do
    echo "$name: p50 $(median $name 500 5) us of $(median c 500 5) us, p99 $(median $name 500 6)" \
        "of $(median c 500 6)"
done
ratio=$(awk "BEGIN { print $(median rust-handler 500 5) / $(median c 500 5) }")
lost=$(awk '$1 == "rust-handler" { n += $4 } END { print n }' "$out/table")
echo "ratio of the handler's p50 to C's: $ratio; lost by Rust: $lost"
if [ "$gate" = --gate ]; then
    [ "$lost" = 0 ] && awk "BEGIN { exit !($ratio <= 0.6) }"
fi
