# The two commands of the README: `make race` and `make test`.
.PHONY: race test lint bench clean

race:
	tools/setup.sh race
	cargo run --release -p vehicle_bridge --bin lmpc -- race --out out/race

test:
	tools/setup.sh race test
	tools/setup-lcm.sh
	cargo test --workspace --release
	tests/interop/types.sh

lint:
	cargo fmt --check
	cargo clippy --workspace --all-targets -- -D warnings
	cargo deny check licenses bans sources

bench:
	cargo bench -p controller

clean:
	cargo clean
	rm -rf out
