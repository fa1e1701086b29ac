#!/bin/sh
# `lmpc view --foxglove` against a client of its WebSocket protocol, in a network namespace of its own: topics,
# schemas and messages are those of `lmpc export --mcap`, and the numbers those of the page.
#
#   tests/interop/foxglove.sh      builds the program with the feature `foxglove`
set -eu
cd "$(dirname "$0")/../.."
tests/interop/needs.sh target/lcm/venv/bin/python
out=target/lcm/foxglove
if [ -z "${LMPC_ISOLATED:-}" ]; then
    cargo build --quiet --locked --release -p vehicle_bridge --bin lmpc --features foxglove
    mkdir -p "$out"
    # The next build without the feature has the name again.
    cp "${CARGO_TARGET_DIR:-target}/release/lmpc" "$out/lmpc"
    LMPC_ISOLATED=1 exec tests/interop/isolated.sh timeout 300 "$0" "$@"
fi
# Of an earlier run; an address in them would be taken for that of this one.
rm -f "$out"/*.txt
export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304'
target/lcm/venv/bin/python tests/interop/foxglove.py "$out/lmpc" "$out"
