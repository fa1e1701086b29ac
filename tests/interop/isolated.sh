#!/bin/sh
# Runs a command in a network namespace of its own with multicast on the loopback interface:
# nothing it sends can leave. Needs unshare (util-linux), ip (iproute2), and user namespaces; with
# --fifo instead of these root, as in a user namespace there is no FIFO priority.
#
#   tests/interop/isolated.sh [--fifo] COMMAND [ARGUMENT...]
"$(dirname "$0")/needs.sh" unshare ip || exit 1
flags=-rn
if [ "$1" = --fifo ]; then
    flags=-n
    shift
    if [ "$(id -u)" != 0 ]; then
        echo "$0 --fifo: needs root, for FIFO priority and a network namespace: use sudo -E" >&2
        exit 1
    fi
elif ! unshare -rn true; then
    echo "$0: no user namespace: run it as root, or allow them: sysctl -w user.max_user_namespaces=1000" \
        "(Ubuntu: sysctl -w kernel.apparmor_restrict_unprivileged_userns=0)" >&2
    exit 1
fi
exec unshare $flags sh -c '
    ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo && exec "$@"
' sh "$@"
