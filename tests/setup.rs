//! What `tools/setup.sh` does on a machine without a Rust toolchain that is new enough: with apt, rustup and
//! cargo that only note how they are called.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;

/// What the script may use of a real system.
const REAL: [&str; 12] =
    ["sh", "sed", "sort", "head", "cut", "grep", "ls", "cat", "env", "id", "dirname", "chmod"];

/// A machine: the programs it has, and what was called.
struct Machine {
    folder: PathBuf,
}

impl Machine {
    /// A machine without Rust and without packages of it.
    fn new(name: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("setup-{name}"));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(folder.join("bin")).unwrap();
        fs::create_dir_all(folder.join("cargo/bin")).unwrap();
        let machine = Self { folder };
        for name in REAL {
            let place = ["/bin", "/usr/bin"].map(|at| Path::new(at).join(name));
            let real = place.into_iter().find(|place| place.exists());
            symlink(real.unwrap_or_else(|| panic!("no {name}")), machine.bin(name)).unwrap();
        }
        machine.has("cc", "exit 0");
        machine.has("sudo", "exec \"$@\"");
        machine.has("rustc", "exit 0");
        machine
    }

    fn bin(&self, name: &str) -> PathBuf {
        self.folder.join("bin").join(name)
    }

    /// Adds a program to it.
    fn has(&self, name: &str, body: &str) {
        executable(&self.bin(name), &format!("#!/bin/sh\n{body}\n"));
    }

    /// Gives it apt with packages of these versions.
    fn offers(&self, packages: &[(&str, &str)]) {
        self.has("apt-get", "echo \"apt-get $*\" >> \"$LOG\"");
        let mut cases = String::new();
        for (package, version) in packages {
            cases += &format!("{package}) candidate={version} ;;\n");
        }
        self.has(
            "apt-cache",
            &format!(
                "candidate='(none)'\ncase $2 in\n{cases}esac\n\
                 printf '%s:\\n  Installed: (none)\\n  Candidate: %s\\n' \"$2\" \"$candidate\""
            ),
        );
    }

    /// Gives it a rustup.
    fn rustup(&self) {
        self.has("rustup", "echo \"rustup $*\" >> \"$LOG\"");
    }

    /// Whether `tools/setup.sh race` succeeds, what it says, and what it called.
    fn setup(&self) -> (bool, String, String) {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tools/setup.sh");
        let log = self.folder.join("log");
        let mut setup = Command::new(self.bin("sh"));
        setup.arg(script).arg("race").env_clear();
        setup.env("PATH", self.folder.join("bin")).env("LOG", &log).env("HOME", &self.folder);
        let ended = setup.env("CARGO_HOME", self.folder.join("cargo")).output().unwrap();
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        (ended.status.success(), said, fs::read_to_string(log).unwrap_or_default())
    }
}

fn executable(path: &Path, text: &str) {
    fs::write(path, text).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
}

/// The oldest Rust of the workspace, as `1.89`.
fn oldest() -> String {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../Cargo.toml");
    let table: toml::Table = fs::read_to_string(manifest).unwrap().parse().unwrap();
    table["workspace"]["package"]["rust-version"].as_str().unwrap().to_owned()
}

fn cargo(version: &str) -> String {
    format!("echo 'cargo {version} (0123456789 2025-01-01)'")
}

#[test]
fn a_toolchain_that_is_new_enough_is_left_alone() {
    for (name, version) in [("least", format!("{}.0", oldest())), ("newer", "1.100.0".to_owned())] {
        let machine = Machine::new(name);
        machine.offers(&[("rustup", "1.27.1-3")]);
        machine.has("cargo", &cargo(&version));
        let (done, said, called) = machine.setup();
        assert!(done, "{version}: {said}");
        assert!(!called.contains("rust") && !called.contains("cargo"), "{version}: {called}");
    }
}

#[test]
fn rustup_of_the_distribution_is_installed_and_installs_the_toolchain() {
    let machine = Machine::new("rustup");
    machine.offers(&[("rustup", "1.27.1-3"), ("cargo", "1.85.0+dfsg3-1")]);
    let name = machine.bin("rustup").display().to_string();
    machine.has(
        "apt-get",
        &format!(
            "echo \"apt-get $*\" >> \"$LOG\"\ncase $* in install*rustup*)\n\
             printf '#!/bin/sh\\necho \"rustup $*\" >> \"$LOG\"\\n' > {name}; chmod +x {name} ;;\nesac"
        ),
    );
    let (done, said, called) = machine.setup();
    assert!(done, "{said}");
    let calls: Vec<&str> = called.lines().collect();
    assert!(calls[0].starts_with("apt-get update"), "{called}");
    let install = calls.iter().position(|c| c.contains(" install ") && c.contains(" rustup"));
    let choose = calls.iter().position(|c| *c == "rustup default stable");
    assert!(install.unwrap() < choose.unwrap(), "{called}");
    assert!(!called.contains(" cargo"), "{called}");
}

#[test]
fn cargo_of_the_distribution_is_installed_if_it_is_new_enough() {
    let machine = Machine::new("cargo");
    machine.offers(&[("cargo", "1.92.0+dfsg1-2")]);
    let (done, said, called) = machine.setup();
    assert!(done, "{said}");
    assert!(called.contains("install") && called.contains(" cargo"), "{called}");
}

#[test]
fn without_a_package_that_is_new_enough_one_command_is_said() {
    let machine = Machine::new("none");
    machine.offers(&[("cargo", "0.66.0+ds1-1")]);
    let without_apt = Machine::new("other-system");
    for machine in [machine, without_apt] {
        let (done, said, called) = machine.setup();
        assert!(!done && said.contains("| sh -s -- -y") && said.contains(&oldest()), "{said}");
        assert!(!called.contains("install"), "{called}");
    }
}

#[test]
fn an_older_toolchain_is_named_with_the_command_and_not_changed() {
    let packages = [("rustup", "1.27.1-3")];
    for (name, rustup, packages, command) in [
        ("old-rustup", true, &packages[..], "rustup default stable && rustup update stable"),
        ("old-offered", false, &packages[..], "apt-get install rustup && rustup default stable"),
        ("old-alone", false, &[], "| sh -s -- -y"),
    ] {
        let machine = Machine::new(name);
        machine.offers(packages);
        machine.has("cargo", &cargo("1.63.0"));
        if rustup {
            machine.rustup();
        }
        let (done, said, called) = machine.setup();
        assert!(!done && said.contains("found Rust 1.63.0") && said.contains(command), "{said}");
        assert!(!called.contains("install") && !called.contains("rustup"), "{called}");
    }
}

#[test]
fn a_rustup_without_a_toolchain_gets_one() {
    let machine = Machine::new("empty-rustup");
    machine.offers(&[]);
    machine.rustup();
    machine.has("cargo", "echo 'rustup could not choose a version of cargo' >&2; exit 1");
    let (done, said, called) = machine.setup();
    assert!(done && called.contains("rustup default stable"), "{said}{called}");
    machine.has("rustup", "exit 1");
    let (done, said, _) = machine.setup();
    assert!(!done && said.contains("rustup could install no toolchain"), "{said}");
}

#[test]
fn a_cargo_beside_the_path_is_named() {
    let machine = Machine::new("beside");
    machine.offers(&[("rustup", "1.27.1-3")]);
    executable(&machine.folder.join("cargo/bin/cargo"), "#!/bin/sh\nexit 0\n");
    let (done, said, called) = machine.setup();
    assert!(!done && said.contains("cargo/env") && !called.contains("install"), "{said}{called}");
}
