#!/bin/sh
# Installs what the named jobs need and the system lacks, saying what and why.
# usage: tools/setup.sh race|test ...
set -eu

missing=""
need() { # package, why, shell test that succeeds if it is there
    if sh -c "$3" >/dev/null 2>&1; then return; fi
    echo "setup: $1 is missing: $2" >&2
    missing="$missing $1"
}

command -v cargo >/dev/null 2>&1 || {
    echo "setup: no Rust toolchain: install rustup and a stable toolchain (1.89 or newer)" >&2
    exit 1
}

for job in "$@"; do
    case "$job" in
    race)
        need gcc "links the program" "command -v cc"
        need libc6-dev "C start-up code the linker needs" "echo 'int main(void){return 0;}' | cc -x c - -o /dev/null"
        ;;
    test) ;;
    *)
        echo "setup: unknown job '$job' (race, test)" >&2
        exit 2
        ;;
    esac
done

[ -z "$missing" ] && exit 0
if ! command -v apt-get >/dev/null 2>&1; then
    echo "setup: this is no Debian or Ubuntu; please install the packages that match:$missing" >&2
    exit 1
fi
sudo=""
[ "$(id -u)" = 0 ] || sudo=sudo
echo "setup: installing$missing" >&2
# shellcheck disable=SC2086 # one word per package
$sudo apt-get update -qq && $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >&2
