//! The test model in FMPy: validated, simulated, and probed with everything a host must not do.
//!
//! Needs Python with FMPy: the one `tools/fmu_tools.sh fmpy` makes, or that named in `LMPC_PYTHON`.
#![allow(clippy::unwrap_used, clippy::panic)]

mod probe;

use std::path::PathBuf;
use std::process::Command;

use fmu_core::{Binary, FmuModel, Platform, VariableType, Version, inspect, pack};
use probe::Probe;

fn target() -> PathBuf {
    let exe = std::env::current_exe().unwrap();
    exe.ancestors().nth(2).unwrap().to_owned()
}

/// Packed into a folder of its own: the tests of this file run at the same time.
fn packed(version: Version, folder: &str) -> PathBuf {
    let binary =
        Binary { platform: Platform::LinuxX64, path: target().join("examples/libprobe.so") };
    let path = target().join(format!("fmu/{folder}/{version:?}/probe.fmu").to_lowercase());
    pack(Probe::description(), version, &[binary], &path).unwrap();
    path
}

fn python(script: &str, arguments: &[PathBuf]) {
    let python = std::env::var_os("LMPC_PYTHON")
        .map_or_else(|| target().join("../tools/fmpy/bin/python"), PathBuf::from);
    let script = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests").join(script);
    let output = Command::new(&python).arg(&script).args(arguments).output().unwrap_or_else(|e| {
        panic!("{}: {e}; `tools/fmu_tools.sh fmpy` makes it", python.display())
    });
    assert!(
        output.status.success(),
        "{} {}: {}\n{}{}",
        python.display(),
        script.display(),
        output.status,
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn fmpy_validates_simulates_and_survives_bad_input() {
    python("fmpy_probe.py", &[Version::Fmi2, Version::Fmi3].map(|version| packed(version, "fmpy")));
}

#[test]
fn packing_twice_gives_the_same_bytes_and_the_parts_are_there() {
    for (version, library, guid) in [
        (Version::Fmi2, "binaries/linux64/probe.so", "guid"),
        (Version::Fmi3, "binaries/x86_64-linux/probe.so", "instantiationToken"),
    ] {
        let path = packed(version, "twice");
        let first = std::fs::read(&path).unwrap();
        assert!(first == std::fs::read(packed(version, "twice")).unwrap());
        let inside = inspect(&path).unwrap();
        let token = Probe::description().token().to_owned();
        assert!(inside.attributes.contains(&(guid.to_owned(), token)));
        let written = Probe::description().table.variables();
        assert_eq!(inside.variables.len(), written.len());
        for (row, variable) in inside.variables.iter().zip(written) {
            assert_eq!(row.name, variable.name);
            assert_eq!(row.description, variable.description);
            assert_eq!(row.unit, variable.unit.map_or("", |unit| unit.name));
            let number = (variable.kind == VariableType::Real && variable.role.settable())
                .then(|| row.start.parse::<f64>().unwrap());
            assert!(number.is_none_or(|start| start == variable.start), "{row:?}");
        }
        let names: Vec<&str> = inside.files.iter().map(|f| f.0.as_str()).collect();
        assert!(names.contains(&library) && names.contains(&"documentation/index.html"));
        assert_eq!(
            names.contains(&"terminalsAndIcons/terminalsAndIcons.xml"),
            version == Version::Fmi3
        );
    }
}
