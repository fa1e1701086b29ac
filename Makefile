# The commands of the README: `make race`, `make test`, `make fmu`, `make book`.
.PHONY: race test test-fast generated tree-size book doc fmu fmu-test fmu-bits fmu-old release deb deb-test \
	wheel campaign-test foxglove-test lint bench clean

race:
	tools/setup.sh race
	cargo run --release -p vehicle_bridge --bin lmpc -- race --out out/race

test:
	tests/all.sh

# Unit tests, the core crates, the source tree and the documents: no packages, no network.
test-fast:
	cargo test --release -p vehicle_model -p track -p controller -p fhocp -p actuators -p neighbors -p house_tests
	cargo test --release -p lcm_types -p safety -p mapping -p svg_page -p optimum_store -p hosting \
		-p atomic_file -p bounded_file -p protocol -p racing -p studies -p log_export -p live_view --lib

# The generated pages of docs/ and the golden files of tests, written anew.
generated:
	LMPC_WRITE_DOCS=1 cargo test --release -p vehicle_model -p controller -p lcm_types -p fmu_core \
		-p vehicle_bridge --test car_page --test configuration_page --test messages_page --test variables_page \
		--test commands_page --test golden

# docs/tree_size.md: lines, files, dependencies and names before the division into small crates and today.
tree-size:
	python3 tools/tree_size.py 96e3a73 --out docs/tree_size.md

# The book of docs/ as HTML, in out/book. Needs `cargo install mdbook --locked`.
book:
	mdbook build docs

doc:
	RUSTDOCFLAGS="-D warnings" cargo doc --release --workspace --no-deps

# One hash for a thousand steps on Linux, wine and ARM64, whatever the host's floating point.
fmu-bits: fmu
	tools/setup.sh fmu fmu-test
	tools/fmu_bits.sh

# Both FMUs for Linux (x64 and ARM64, glibc 2.17 or newer) and Windows, FMI 2.0 and 3.0, and the
# wired systems, in out/fmu.
fmu:
	tools/setup.sh race fmu
	tools/pack_fmus.sh

# Both FMUs in every importer that is not ours, under Valgrind, wine and qemu.
fmu-test: fmu
	tools/setup.sh fmu fmu-test
	tests/fmus.sh

# The FMUs in a Debian 11 (glibc 2.31) of their own; needs root for the chroot.
fmu-old: fmu
	tools/setup.sh fmu-old
	tools/fmu_old.sh

# The program for Linux (x64 and ARM64, glibc 2.17 or newer), in out/release; starts without liblcm.
release:
	tools/setup.sh race fmu
	tools/release.sh

# The Debian package of the program for this machine, in out/deb.
deb:
	tools/setup.sh race
	tools/deb.sh

# What is in the package; as root it is installed, used and purged behind an overlay.
deb-test: deb
	tests/interop/deb.sh

# The server of `lmpc view --foxglove`, which is no part of the usual build: lints, then a client.
foxglove-test:
	tools/setup.sh race test
	tools/setup-lcm.sh
	cargo clippy --release -p vehicle_bridge --features foxglove -- -D warnings
	tests/interop/foxglove.sh

# 2,000 runs in three shards, one killed and resumed, and the built-in studies against their files.
campaign-test:
	tools/setup.sh race
	tests/interop/campaign.sh

# The wheels of the Python package for Linux (x64 and ARM64, glibc 2.17 or newer) with the FMUs inside, in
# out/wheels.
wheel: fmu
	tools/setup.sh race fmu
	tools/wheel.sh

lint:
	cargo fmt --check
	cargo clippy --workspace --all-targets -- -D warnings
	$(MAKE) doc
	cargo deny check

bench:
	cargo bench -p fhocp -p vehicle_bridge

clean:
	cargo clean
	rm -rf out
