//! Libraries an FMU needs in the process before its own.
#![allow(unsafe_code, reason = "shared libraries of others are loaded")]

use std::path::Path;
use std::process::Command;

use fmu_core::Inspection;
use libloading::os::unix::{Library, RTLD_GLOBAL, RTLD_NOW};

/// What tells that PythonFMU made an FMU: it expects to be loaded by a Python.
const PYTHON_MARK: &str = "resources/slavemodule.txt";
const PYTHON_ASKS: &str = "import os, sysconfig as s; \
    print(os.path.join(s.get_config_var('LIBDIR'), s.get_config_var('INSTSONAME')))";

/// Loads the library named, or the one this FMU is known to need.
///
/// # Errors
/// In words, if there is none or it cannot be loaded.
pub(super) fn preload(inspection: &Inspection, library: Option<&Path>) -> Result<(), String> {
    let python = inspection.files.iter().any(|(name, _)| name == PYTHON_MARK);
    let library = match library {
        Some(library) => library.display().to_string(),
        None if python => python_library()?,
        None => return Ok(()),
    };
    // SAFETY: its initialisers are as trusted as the FMU that asks for it.
    let loaded = unsafe { Library::open(Some(&library), RTLD_NOW | RTLD_GLOBAL) };
    // Never unloaded: the FMU's code refers to it as long as the process lives.
    let _ = loaded.map_err(|e| format!("cannot preload {library}: {e}"))?.into_raw();
    Ok(())
}

fn python_library() -> Result<String, String> {
    let hint = "a PythonFMU needs libpython; name it with --preload";
    let told = Command::new("python3").args(["-c", PYTHON_ASKS]).output();
    let told = told.map_err(|e| format!("cannot run python3 ({e}); {hint}"))?;
    let path = String::from_utf8_lossy(&told.stdout).trim().to_owned();
    if told.status.success() && Path::new(&path).exists() {
        return Ok(path);
    }
    Err(format!("python3 has no shared library (`{path}`); {hint}"))
}
