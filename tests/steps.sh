# Sourced by the scripts that run others one after the other, and some beside them.
# shellcheck shell=sh
logs=${CARGO_TARGET_DIR:-target}/steps
mkdir -p "$logs"
began=$(date +%s)
running=
# `timeout` leads a group of processes and passes on to all of them what ends it.
trap '[ -z "$running" ] || kill $running 2>/dev/null || true' EXIT

since() { echo "$(($(date +%s) - $1)) s"; }
step() { # command: says how long it took
    echo "== $*"
    start=$(date +%s)
    "$@"
    echo "-- $*: $(since "$start"), $(since "$began") in all"
}
beside() { # name, command: starts it
    name=$1
    shift
    timeout 3600 "$@" >"$logs/$name" 2>&1 &
    running="$running $!"
    eval "$name=$!"
}
joined() { # name: waits until it has ended, and prints what it printed
    start=$(date +%s)
    code=0
    eval "id=\$$1"
    wait "$id" || code=$?
    running=$(echo "$running " | sed "s/ $id / /; s/ $//")
    echo "== beside the other steps: $1"
    cat "$logs/$1"
    echo "-- $1: waited $(since "$start"), $(since "$began") in all"
    [ $code = 0 ] || { echo "$1 failed with $code" >&2; exit 1; }
}
