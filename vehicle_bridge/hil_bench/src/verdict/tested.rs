//! What was tested: the opening of a verdict.

use std::fs;
use std::path::Path;

use serde::Serialize;
use sha2::{Digest as _, Sha256};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use crate::bench::Bench;
use crate::stall::Stood;
use hosting::load;

/// Digits of a fingerprint that people compare.
const DIGITS: usize = 16;

/// What was tested, on what, when, by whom.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Tested {
    /// Version of this program, with the revision it was built from where that was known.
    pub version: String,
    /// Kind of build, its processor and system, and the program file's fingerprint.
    pub build: String,
    /// Car, with the fingerprint of its parameters.
    pub car: String,
    /// Track, with its fingerprint and length.
    pub track: String,
    /// Bench file, with the SHA-256 of its bytes.
    pub bench: String,
    /// What options changed of the file: runs, seeds, the choice of scenarios.
    pub options: String,
    /// Name of the computer, processor, system.
    pub machine: String,
    /// When the test began, RFC 3339 in UTC.
    pub date: String,
    /// How long it took. \[s\]
    pub duration_s: f64,
    /// Times the computer stood still for more than 5 ms. \[-\]
    pub stalls: usize,
    /// The longest of them. \[s\]
    pub longest_stall_s: f64,
    /// Who tested; empty where it is to be filled in by hand.
    pub tester: String,
}

impl Tested {
    /// At the beginning of a test by this program, whose file is `lmpc`.
    ///
    /// # Errors
    /// If car or track cannot be loaded.
    pub fn new(bench: &Bench, file: &Path, lmpc: &Path) -> anyhow::Result<Self> {
        let (car, track) = (load::car(&bench.car)?, load::track(&bench.track)?);
        let version = env!("CARGO_PKG_VERSION");
        let profile = if cfg!(debug_assertions) { "debug" } else { "release" };
        let (arch, os) = (std::env::consts::ARCH, std::env::consts::OS);
        Ok(Self {
            version: match option_env!("LMPC_REVISION") {
                Some(revision) => format!("{version} ({revision})"),
                None => version.to_owned(),
            },
            build: format!("{profile}, {arch} {os}, SHA-256 {}", fingerprint(lmpc)),
            car: format!("{} ({:016x})", car.name, car.fingerprint()),
            track: format!(
                "{} ({:016x}), {:.1} m",
                track.name(),
                track.fingerprint(),
                track.length()
            ),
            bench: format!("{}, SHA-256 {}", file.display(), fingerprint(file)),
            options: String::new(),
            machine: machine(),
            date: OffsetDateTime::now_utc()
                .replace_nanosecond(0)
                .ok()
                .and_then(|now| now.format(&Rfc3339).ok())
                .unwrap_or_default(),
            ..Self::default()
        })
    }

    /// Notes how long it took and how often the computer stood still meanwhile.
    pub fn ended(&mut self, duration_s: f64, stood: Stood) {
        self.duration_s = duration_s;
        (self.stalls, self.longest_stall_s) = (stood.times, stood.longest);
    }

    /// Name and value of each line.
    #[must_use]
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let of = |text: &str| text.to_owned();
        let mut lines = vec![
            ("version", format!("lmpc {}", self.version)),
            ("build", of(&self.build)),
            ("car", of(&self.car)),
            ("track", of(&self.track)),
            ("bench", of(&self.bench)),
        ];
        if !self.options.is_empty() {
            lines.push(("options", of(&self.options)));
        }
        let stalls = match self.stalls {
            0 => of("never for more than 5 ms"),
            n => format!(
                "{n} times for more than 5 ms, at most {:.1} ms",
                self.longest_stall_s * 1e3
            ),
        };
        lines.extend([
            ("machine", of(&self.machine)),
            ("machine stood still", stalls),
            ("date", of(&self.date)),
            ("duration", duration(self.duration_s)),
            ("tested by", of(&self.tester)),
        ]);
        lines
    }
}

/// The beginning of a file's SHA-256, as `sha256sum` prints it.
fn fingerprint(file: &Path) -> String {
    let Ok(bytes) = fs::read(file) else { return "unknown".to_owned() };
    let all: String = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    all.chars().take(DIGITS).collect()
}

/// Name, processor, number of processors, kernel.
fn machine() -> String {
    let read = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let host = nix::unistd::gethostname().unwrap_or_default();
    let info = read("/proc/cpuinfo");
    let model = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let model = model.map_or(std::env::consts::ARCH, |(_, name)| name.trim());
    let count = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let kernel = read("/proc/sys/kernel/osrelease");
    format!("{}: {count} x {model}, Linux {}", host.to_string_lossy(), kernel.trim())
}

fn duration(seconds: f64) -> String {
    let minutes = (seconds / 60.0).floor();
    if minutes < 1.0 {
        format!("{seconds:.1} s")
    } else {
        format!("{minutes} min {:.0} s", (seconds - 60.0 * minutes).floor())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use super::*;

    #[test]
    fn a_fingerprint_is_what_sha256sum_prints() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("bench.toml");
        fs::write(&file, "abc").unwrap();
        // FIPS 180-2, appendix B.1.
        assert_eq!(fingerprint(&file), "ba7816bf8f01cfea");
        assert_eq!(fingerprint(&folder.path().join("none")), "unknown");
    }

    #[test]
    fn every_line_of_what_was_tested_is_filled_in() {
        let text = "title = \"t\"\n[[scenario]]\nname = \"s\"\n";
        let bench: Bench = toml::from_str(text).unwrap();
        let mut tested = Tested::new(&bench, Path::new("b.toml"), Path::new("lmpc")).unwrap();
        tested.ended(62.0, Stood { times: 2, longest: 0.0071 });
        let lines = tested.lines();
        let empty: Vec<_> = lines.iter().filter(|line| line.1.is_empty()).map(|l| l.0).collect();
        assert_eq!(empty, ["tested by"]);
        let of = |name| &lines.iter().find(|line| line.0 == name).unwrap().1;
        assert!(of("date").ends_with('Z') && of("date").len() == 20, "{}", of("date"));
        assert_eq!(of("duration"), "1 min 2 s");
        assert!(of("machine stood still").ends_with("at most 7.1 ms"));
        assert!(of("car").starts_with("barc"), "{}", of("car"));
    }
}
