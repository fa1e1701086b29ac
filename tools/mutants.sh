#!/bin/sh
# Mutation tests of the safety core and of the limiter: cargo-mutants on a small package that holds
# only them and their tests, so that a mutant takes seconds. Arguments go to `cargo mutants`.
# Needs `cargo install cargo-mutants --locked`. Settings: .cargo/mutants.toml.
set -eu
cd "$(dirname "$0")/.."
root=$PWD
package=${CARGO_TARGET_DIR:-target}/mutants/package
rm -rf "$package/src" && mkdir -p "$package/src" "$package/.cargo"
cp -r vehicle_bridge/safety/src/. vehicle_model/src/limiter.rs "$package/src/"
cp .cargo/mutants.toml "$package/.cargo/"
cp Cargo.lock "$package/"
echo 'pub mod limiter;' >> "$package/src/lib.rs"
# The limiter's own copy: mutants of it are judged by its own tests.
sed -i 's/^use crate::params::CarParams;/use vehicle_model::CarParams;/
        s/^use crate::state::Input;/use vehicle_model::Input;/' "$package/src/limiter.rs"
{
    cat <<TOML
[package]
name = "mutants"
edition = "2024"
[workspace]
[dependencies]
lcm_types = { path = "$root/lcm_types" }
vehicle_model = { path = "$root/vehicle_model" }
TOML
    grep -E '^(thiserror|rand|rand_distr|rand_pcg) = ' Cargo.toml
    printf '[profile.dev]\nopt-level = 1\ndebug = false\n[profile.dev.package."*"]\nopt-level = 2\n'
} > "$package/Cargo.toml"
cd "$package"
# The package is a copy already; in place, what it depends on is built once and kept.
[ "${CARGO_MUTANTS:-mutants}" != mutants ] || set -- --in-place "$@"
exec cargo "${CARGO_MUTANTS:-mutants}" "$@"
