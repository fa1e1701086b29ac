# Sourced by the scripts that drive both libraries through one race: builds the C importer of
# fmu/tests/host/race.c for a platform. shellcheck shell=sh
. tools/zig.sh
command -v unzip >/dev/null || { echo "unzip is missing: apt-get install unzip" >&2; exit 1; }

race_for() { # zig's target, program
    "$zig_tools/python" -m ziglang cc -target "$1" -O1 -fno-sanitize=undefined -w -o "$2" \
        fmu/tests/host/race.c
}
