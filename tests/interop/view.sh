#!/bin/sh
# `lmpc view` in a real browser, in a network namespace of its own: a car at 100 Hz, a restart of the
# controller and of the page's server, a recorded drive, a race, an operator with a key.
#
#   tests/interop/view.sh [FOLDER] [--minutes N]
#
# With FOLDER it leaves there the pictures of the book, view-desktop.png and view-phone.png; with
# --minutes it also watches the memory of page and server for so long.
set -eu
cd "$(dirname "$0")/../.."
tests/interop/needs.sh target/lcm/venv/bin/python
if [ -z "${LMPC_ISOLATED:-}" ]; then
    tools/build.sh --quiet
    LMPC_ISOLATED=1 exec tests/interop/isolated.sh timeout 1200 "$0" "$@"
fi
out=target/lcm/view
rm -rf "$out" && mkdir -p "$out"
export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304'
target/lcm/venv/bin/python tests/interop/view.py target/release/lmpc "$out" "$@"
