#!/bin/sh
# lcm-spy with our types under a virtual screen: builds the jar, sends traffic inside a network
# namespace, and leaves a picture of the live channels in target/lcm/spy.png.
#
# Needs xvfb and imagemagick besides what tools/types-jar.sh needs. Fails if a channel has no
# row in the window.
set -eu
cd "$(dirname "$0")/../.."
tests/interop/needs.sh Xvfb import convert target/lcm/venv/bin/python
if [ -z "${LMPC_ISOLATED:-}" ]; then
    tools/types-jar.sh
    tools/build.sh --quiet
    LMPC_ISOLATED=1 exec tests/interop/isolated.sh "$0" "$@"
fi
site=$(target/lcm/venv/bin/python -c 'import lcm, os; print(os.path.dirname(os.path.dirname(lcm.__file__)))')
export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0' DISPLAY=:97
Xvfb :97 -screen 0 900x500x24 >/dev/null 2>&1 &
screen=$!
for _ in $(seq 100); do
    [ ! -S /tmp/.X11-unix/X97 ] || break
    sleep 0.1
done
target/release/examples/lcm_traffic 25 &
traffic=$!
CLASSPATH=$PWD/target/lcm/types.jar sh "$site/bin/lcm-spy" &
spy=$!
trap 'kill $spy $traffic $screen 2>/dev/null || true' EXIT
# Each of the three channels has a row; an empty part of the table is of one colour.
rows() {
    import -window root target/lcm/spy.png
    for top in 21 37 53; do
        colours=$(convert target/lcm/spy.png -crop "300x13+3+$top" +repage -format '%k' info:)
        echo "target/lcm/spy.png: $colours colours in the row at $top"
        [ "$colours" -gt 1 ] || return 1
    done
}
for _ in $(seq 20); do
    sleep 1
    if rows >/dev/null; then break; fi
done
# The window is drawn in parts.
sleep 2
rows
