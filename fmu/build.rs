//! A hash of the sources behind the FMUs, so that their token and their saved states belong to one
//! build: a library never meets the model description or the state of another.
#![allow(clippy::print_stdout)]

use std::path::{Path, PathBuf};

const FOLDERS: [&str; 12] = [
    "src",
    "../controller/src",
    "../controller/actuators/src",
    "../controller/fhocp/src",
    "../controller/neighbors/src",
    "../controller/vector_sums/src",
    "../vehicle_bridge/atomic_file/src",
    "../vehicle_bridge/bounded_file/src",
    "../vehicle_model/src",
    "../vehicle_model/track/src",
    "../cars",
    "../tracks",
];

fn files(folder: &Path, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            files(&path, found)?;
        } else {
            found.push(path);
        }
    }
    Ok(())
}

fn main() -> std::io::Result<()> {
    let mut found = Vec::new();
    for folder in FOLDERS {
        println!("cargo::rerun-if-changed={folder}");
        files(Path::new(folder), &mut found)?;
    }
    // With the versions of all that is linked in.
    println!("cargo::rerun-if-changed=../Cargo.lock");
    found.push(PathBuf::from("../Cargo.lock"));
    // The order of a folder's entries is the file system's.
    found.sort();
    // FNV-1a, as in src/checksum.rs, over contents without line-end conversions.
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for path in found {
        for byte in std::fs::read(path)?.into_iter().filter(|b| *b != b'\r') {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
    println!("cargo::rustc-env=LMPC_FMU_SOURCES={hash:016x}");
    Ok(())
}
