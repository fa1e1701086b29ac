//! Packs what `tools/fmu.sh` built: `ship <folder with the targets' libraries> <output folder>`.
#![allow(clippy::print_stdout)]

use std::path::PathBuf;

use fmu_core::{Libraries, Platform, ship};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [libraries, out] = arguments.as_slice() else {
        return Err("usage: ship <libraries> <out>".into());
    };
    let known = [
        (Platform::LinuxX64, "x86_64-unknown-linux-gnu"),
        (Platform::WindowsX64, "x86_64-pc-windows-gnu"),
        (Platform::LinuxArm64, "aarch64-unknown-linux-gnu"),
    ];
    let folders =
        known.map(|(platform, name)| Libraries { platform, folder: libraries.join(name) });
    let found: Vec<Libraries> = folders.into_iter().filter(|l| l.folder.is_dir()).collect();
    for file in ship(&found, out)? {
        println!("{}", file.display());
    }
    Ok(())
}
