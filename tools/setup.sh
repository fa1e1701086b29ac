#!/bin/sh
# Installs what the named jobs need and the system lacks, saying what and why.
# usage: tools/setup.sh race|test|fmu|fmu-test|fmu-old ...
set -eu

missing=""
targets=""
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
        need libclang-dev "bindings for the FMUs of other vendors are made from the FMI headers" "ls /usr/lib/llvm*/lib /usr/lib/*-linux-gnu | grep -qE '^libclang(-[0-9.]+)?[.]so'"
        need libc6-dev "C start-up code the linker needs" "echo 'int main(void){return 0;}' | cc -x c - -o /dev/null"
        ;;
    test)
        need liblcm1 "the C library behind the LCM networks other than UDP" "ls /usr/lib/*/liblcm.so.1"
        need liblcm-bin "lcm-gen and lcm-logger, what our messages and logs are compared with" "command -v lcm-gen"
        need iproute2 "sets up the network namespaces the network tests run in" "command -v ip"
        need default-jdk-headless "builds the jar from which lcm-spy knows our messages" "command -v javac && command -v jar"
        need xvfb "the screen lcm-spy is looked at on" "command -v Xvfb"
        need imagemagick "takes the picture of that screen" "command -v import && command -v convert"
        need valgrind "counts the instructions of a control step" "command -v valgrind"
        need chromium "lays out the verdict of a bench and opens the live view" "command -v chromium || command -v chromium-browser || command -v google-chrome"
        need slurm-wlm "runs a campaign as an array of jobs" "PATH=\$PATH:/usr/sbin; command -v slurmctld && command -v slurmd && command -v sbatch"
        need munge "lets the parts of Slurm know each other" "PATH=\$PATH:/usr/sbin; command -v munged"
        need util-linux "makes those namespaces" "command -v unshare"
        need python3-venv "the official Python package of LCM goes in a venv" "python3 -c 'import ensurepip'"
        ;;
    fmu)
        need gcc-mingw-w64-x86-64 "links the Windows libraries of the FMUs" "command -v x86_64-w64-mingw32-gcc"
        need python3-venv "zig, which links for an old glibc, goes in a venv" "python3 -c 'import ensurepip'"
        need binutils "reads which glibc a library needs" "command -v readelf"
        targets="x86_64-unknown-linux-gnu aarch64-unknown-linux-gnu x86_64-pc-windows-gnu"
        ;;
    fmu-test)
        need python3-venv "the co-simulation tools go in a venv each" "python3 -c 'import ensurepip'"
        need libxml2-utils "xmllint holds descriptions to the schemas" "command -v xmllint"
        need libtbb12 "Ecos needs it" "ls /usr/lib/*/libtbb.so.12"
        need binutils "lists what a library needs" "command -v objdump && command -v strings"
        need unzip "looks into FMUs" "command -v unzip"
        need valgrind "leaks and invalid accesses of the libraries" "command -v valgrind"
        need gcc-aarch64-linux-gnu "builds the importer that runs the ARM libraries" "command -v aarch64-linux-gnu-gcc"
        need libc6-dev-arm64-cross "the C library of that importer" "test -e /usr/aarch64-linux-gnu/lib/libc.so.6"
        need qemu-user "runs the ARM libraries" "command -v qemu-aarch64"
        need wine64 "runs the Windows libraries" "command -v wine64 || command -v wine || test -x /usr/lib/wine/wine64"
        ;;
    fmu-old)
        need debootstrap "makes the Debian 11 the libraries are tried in" "command -v debootstrap || test -x /usr/sbin/debootstrap"
        ;;
    *)
        echo "setup: unknown job '$job' (race, test, fmu, fmu-test, fmu-old)" >&2
        exit 2
        ;;
    esac
done

# The standard library of other machines comes from rustup, or with the system's toolchain.
for target in $targets; do
    [ ! -d "$(rustc --print sysroot)/lib/rustlib/$target/lib" ] || continue
    echo "setup: the Rust target $target is missing: the FMUs are built for it" >&2
    if ! { command -v rustup >/dev/null 2>&1 && rustup target add "$target" >&2; }; then
        echo "setup: rustup could not add it; with rustup installed: rustup target add $target" >&2
        exit 1
    fi
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
