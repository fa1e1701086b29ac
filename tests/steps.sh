# Sourced by the scripts that run others one after the other.
# shellcheck shell=sh
log=${CARGO_TARGET_DIR:-target}/beside.log
mkdir -p "$(dirname "$log")"
began=$(date +%s)
running=
# `timeout` leads a group of processes and passes on to all of them what ends it.
trap '[ -z "$running" ] || kill "$running" 2>/dev/null || true' EXIT

since() { echo "$(($(date +%s) - $1)) s"; }
step() { # command: says how long it took
    echo "== $*"
    start=$(date +%s)
    "$@"
    echo "-- $*: $(since "$start"), $(since "$began") in all"
}
beside() { # command: starts it beside the steps that follow
    timeout 3600 "$@" >"$log" 2>&1 &
    running=$!
}
joined() { # waits until it has ended, and prints what it printed
    start=$(date +%s)
    code=0
    wait "$running" || code=$?
    running=
    echo "== beside the other steps"
    cat "$log"
    echo "-- waited $(since "$start"), $(since "$began") in all"
    [ $code = 0 ] || { echo "it failed with $code" >&2; exit 1; }
}
