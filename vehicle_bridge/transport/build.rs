//! Answers the linker's search for liblcm, which the program loads itself when a URL needs it
//! (`src/transport/liblcm_loaded.rs`): an empty archive, and for linkers that look for a shared
//! library alone a script that names it.
#![allow(clippy::print_stdout)]

use std::path::PathBuf;

fn main() -> std::io::Result<()> {
    println!("cargo::rerun-if-changed=build.rs");
    let Some(folder) = std::env::var_os("OUT_DIR").map(PathBuf::from) else {
        return Err(std::io::Error::other("cargo sets OUT_DIR"));
    };
    std::fs::write(folder.join("liblcm.a"), b"!<arch>\n")?;
    std::fs::write(folder.join("liblcm.so"), b"INPUT ( liblcm.a )\n")?;
    println!("cargo::rustc-link-search=native={}", folder.display());
    Ok(())
}
