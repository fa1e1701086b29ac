#!/bin/sh
# Installs what the LCM transport links and what its interoperability tests run, or fails.
#
#   tools/setup-lcm.sh          liblcm for building; the product needs no more
#   tools/setup-lcm.sh --test   also lcm-gen, lcm-logger and the Python package, in target/lcm/venv
set -eu
cd "$(dirname "$0")/.."

packages=
need() { # need FILE-OR-COMMAND PACKAGE
    command -v "$1" >/dev/null 2>&1 || [ -e "$1" ] || packages="$packages $2"
}
need /usr/include/lcm/lcm.h liblcm-dev
if [ "${1:-}" = --test ]; then
    need lcm-gen liblcm-bin
    need ip iproute2
    need unshare util-linux
    need python3 python3
    python3 -c 'import ensurepip' 2>/dev/null || packages="$packages python3-venv"
fi

if [ -n "$packages" ]; then
    run=
    [ "$(id -u)" = 0 ] || run=sudo
    # Another installer may hold the lock for a while.
    wait="-o DPkg::Lock::Timeout=300"
    if ! command -v apt-get >/dev/null; then
        echo "setup-lcm: install by hand:$packages" >&2
        exit 1
    fi
    $run apt-get $wait update -qq
    $run env DEBIAN_FRONTEND=noninteractive \
        apt-get $wait install -y -qq --no-install-recommends $packages
fi

if [ "${1:-}" = --test ]; then
    python=target/lcm/venv/bin/python
    if ! "$python" -c 'import lcm' 2>/dev/null; then
        mkdir -p target/lcm
        python3 -m venv target/lcm/venv
        "$python" -m pip install --quiet lcm==1.5.3
    fi
    "$python" -c 'import lcm'
    lcm-gen --version >/dev/null
    unshare -rn ip link set lo up
fi
