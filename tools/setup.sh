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

have_apt() { command -v apt-get >/dev/null 2>&1; }
sudo=""
[ "$(id -u)" = 0 ] || sudo=sudo
updated=""
update() { # the lists of packages, once
    [ -n "$updated" ] || $sudo apt-get update -qq >&2 || true
    updated=yes
}

# The Rust toolchain. One that is there is not changed: then this says the command that does.
least=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' "$(dirname "$0")/../Cargo.toml")
# Whether a version is not below $least.
enough() { [ "$(printf '%s\n' "$least" "$1" | sort -V | head -n 1)" = "$least" ]; }
# The version of a package that apt would install.
offered() { LC_ALL=C apt-cache policy "$1" 2>/dev/null | sed -n 's/^  Candidate: \([^(]\)/\1/p'; }
have=$(cargo --version 2>/dev/null | cut -d ' ' -f 2) || have=""
no_rust() { # what was found, command that mends it
    echo "setup: $1, expected Rust $least or newer. Run this, then the same again: $2" >&2
    exit 1
}
script="curl --proto '=https' --tlsv1.2 -sSf https://sh.rustup.rs | sh -s -- -y && . \"\$HOME/.cargo/env\""
choose_toolchain=""
if [ -n "$have" ]; then
    if ! enough "$have"; then
        if command -v rustup >/dev/null 2>&1; then
            no_rust "found Rust $have" "rustup default stable && rustup update stable"
        elif have_apt && update && [ -n "$(offered rustup)" ]; then
            no_rust "found Rust $have" "$sudo${sudo:+ }apt-get install rustup && rustup default stable"
        fi
        no_rust "found Rust $have" "$script"
    fi
elif command -v rustup >/dev/null 2>&1; then
    choose_toolchain=yes
elif [ -x "${CARGO_HOME:-$HOME/.cargo}/bin/cargo" ]; then
    no_rust "cargo is not on the PATH" ". \"${CARGO_HOME:-$HOME/.cargo}/env\""
elif have_apt && update && [ -n "$(offered rustup)" ]; then
    echo "setup: rustup is missing: it installs the Rust toolchain" >&2
    missing=" rustup"
    choose_toolchain=yes
elif have_apt && enough "$(offered cargo)"; then
    echo "setup: cargo is missing: it builds everything here" >&2
    missing=" cargo"
else
    no_rust "found no Rust toolchain and no package of one" "$script"
fi

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

if [ -n "$missing" ]; then
    if ! have_apt; then
        echo "setup: this is no Debian or Ubuntu; please install the packages that match:$missing" >&2
        exit 1
    fi
    echo "setup: installing$missing" >&2
    update
    # shellcheck disable=SC2086 # one word per package
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >&2
fi
if [ -n "$choose_toolchain" ]; then
    echo "setup: rustup has no toolchain: it installs the stable one" >&2
    rustup default stable >&2 || no_rust "rustup could install no toolchain" "rustup default stable"
fi

# The standard library of other machines comes from rustup, or with the system's toolchain.
for target in $targets; do
    [ ! -d "$(rustc --print sysroot)/lib/rustlib/$target/lib" ] || continue
    echo "setup: the Rust target $target is missing: the FMUs are built for it" >&2
    if ! { command -v rustup >/dev/null 2>&1 && rustup target add "$target" >&2; }; then
        echo "setup: rustup could not add it; with rustup installed: rustup target add $target" >&2
        exit 1
    fi
done
