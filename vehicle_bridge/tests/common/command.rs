//! `lmpc` as a command that is run to its end.
#![allow(clippy::unwrap_used, reason = "code of tests")]

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

/// A folder of its own for each test, removed when it is done.
#[allow(dead_code, reason = "not every test writes files")]
pub(crate) struct Folder(pub(crate) PathBuf);

#[allow(dead_code, reason = "not every test writes files")]
impl Folder {
    pub(crate) fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("lmpc-cli-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub(crate) fn file(&self, name: &str, text: &str) -> String {
        let path = self.0.join(name);
        fs::write(&path, text).unwrap();
        path.display().to_string()
    }

    pub(crate) fn read(&self, name: &str) -> String {
        fs::read_to_string(self.0.join(name)).unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Runs `lmpc`, without colours, to its end.
pub(crate) fn lmpc(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lmpc")).args(arguments).env("NO_COLOR", "1").output().unwrap()
}

#[allow(dead_code, reason = "not every test reads what was said")]
pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}
