//! Files: space for logs, configurations, FMUs.

use std::path::Path;

use nix::sys::statvfs::statvfs;

use super::Finding;
use file_check::check_file;

/// An hour of everything on the network at 100 Hz. \[B\]
const HOUR: u64 = 2 << 30;
/// Below this a log ends within minutes. \[B\]
const MINUTES: u64 = 64 << 20;

/// Where this computer's FMU libraries are in an FMU, by version of the standard.
const BINARIES: [&str; 2] = if cfg!(target_arch = "aarch64") {
    ["binaries/aarch64-linux/", "binaries/linuxaarch64/"]
} else {
    ["binaries/x86_64-linux/", "binaries/linux64/"]
};

/// Space and rights where logs go.
pub(super) fn disk(folder: &Path) -> Finding {
    const SUBJECT: &str = "disk for logs";
    let name = folder.display();
    let probe = folder.join(format!(".lmpc-doctor-{}", std::process::id()));
    let written = std::fs::write(&probe, b"?").and_then(|()| std::fs::remove_file(&probe));
    if let Err(error) = written {
        return Finding::fail(
            SUBJECT,
            format!("{name}: {error}"),
            format!("mkdir -p {name}, or --logs DIR"),
        );
    }
    let free = statvfs(folder).map(|space| space.blocks_available() * space.fragment_size());
    match free {
        Ok(free) if free >= HOUR => Finding::ok(SUBJECT, format!("{name}: {} MB free", free >> 20)),
        Ok(free) => {
            let found =
                format!("{name}: {} MB free; an hour takes up to {} MB", free >> 20, HOUR >> 20);
            let make = if free < MINUTES { Finding::fail } else { Finding::warn };
            make(SUBJECT, found, "free space there, or --logs DIR on another disk".to_owned())
        }
        Err(error) => Finding::warn(SUBJECT, format!("{name}: {error}"), "--logs DIR elsewhere"),
    }
}

/// Whether `lmpc check` finds nothing.
pub(super) fn valid(file: &Path) -> Finding {
    const SUBJECT: &str = "file";
    let checked = check_file(file);
    match checked.problems.as_slice() {
        [] => Finding::ok(SUBJECT, format!("{}: {}, no problems", checked.file, checked.kind)),
        [first, rest @ ..] => {
            let more =
                if rest.is_empty() { String::new() } else { format!("; {} more", rest.len()) };
            let found = format!("{}: {}, {first}{more}", checked.file, checked.kind);
            Finding::fail(SUBJECT, found, format!("lmpc check {} names them all", checked.file))
        }
    }
}

/// Whether an FMU can be read and has a library for this computer.
pub(super) fn fmu(file: &Path) -> Finding {
    const SUBJECT: &str = "FMU";
    let name = file.display();
    match fmu_core::inspect(file) {
        Err(error) => {
            Finding::fail(SUBJECT, error.to_string(), "pack it again; see `lmpc fmu inspect`")
        }
        Ok(inside) => {
            let ours = |(path, _): &(String, u64)| BINARIES.iter().any(|b| path.starts_with(b));
            match inside.files.iter().find(|file| ours(file)) {
                Some((path, _)) => Finding::ok(SUBJECT, format!("{name}: {path}")),
                None => Finding::fail(
                    SUBJECT,
                    format!("{name}: no library in {}", BINARIES.join(" or ")),
                    "export it with binaries for this platform",
                ),
            }
        }
    }
}
