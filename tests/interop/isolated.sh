#!/bin/sh
# Runs a command in a network namespace of its own with multicast on the loopback interface:
# nothing it sends can leave. Needs unshare (util-linux), ip (iproute2), and user namespaces.
"$(dirname "$0")/needs.sh" unshare ip || exit 1
if ! unshare -rn true; then
    echo "$0: no user namespace: run it as root, or allow them: sysctl -w user.max_user_namespaces=1000" \
        "(Ubuntu: sysctl -w kernel.apparmor_restrict_unprivileged_userns=0)" >&2
    exit 1
fi
exec unshare -rn sh -c '
    ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo && exec "$@"
' sh "$@"
