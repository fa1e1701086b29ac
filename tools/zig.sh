# Sourced by the scripts that build for other machines: puts cargo-zigbuild and zig, as a linker
# that knows every glibc, on the path. GLIBC is the oldest that what we ship may need; it is the
# oldest Rust's standard library runs on, that of RHEL 7.
# shellcheck shell=sh
GLIBC=2.17
tools/fmu_tools.sh zig
zig_tools=$(cd "${CARGO_TARGET_DIR:-target}/tools/zig/bin" && pwd)
PATH="$zig_tools:$PATH"
export PATH GLIBC
