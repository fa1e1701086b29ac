#!/bin/sh
# Puts the official Python packages of LCM, with its own lcm-gen and tools, of MCAP, Playwright, which
# drives the browser, and a WebSocket client into target/lcm/venv.
# `tools/setup.sh test` installs what the system lacks for it.
set -eu
cd "$(dirname "$0")/.."
python=target/lcm/venv/bin/python
if ! "$python" -c 'import lcm, mcap, playwright, websockets' 2>/dev/null; then
    mkdir -p target/lcm
    python3 -m venv target/lcm/venv
    "$python" -m pip install --quiet lcm==1.5.3 mcap==1.3.0 playwright==1.65.2 \
        websockets==17.4
fi
"$python" -c 'import lcm, mcap, playwright, websockets'
