//! `lmpc` without arguments: what one can do first.

use std::io;

use terminal::{BEST, SOFT, paint, result};

const FIRST: [(&str, &[(&str, &str)]); 4] = [
    (
        "In a minute",
        &[("lmpc tour", "a race, its report, FMUs, a car on a network: each command shown")],
    ),
    (
        "In studies",
        &[
            ("lmpc race", "20 laps of a simulated car: out/race/report.html"),
            (
                "lmpc study FILE.toml",
                "many races: settings, cars, tracks, seeds, also on a cluster",
            ),
        ],
    ),
    (
        "In co-simulation",
        &[
            ("lmpc fmu inspect FILE.fmu", "the variables of any FMU; `make fmu` builds ours"),
            ("lmpc race --vehicle fmu:FILE.fmu", "your vehicle model as the car"),
        ],
    ),
    (
        "At a car or a bench",
        &[
            ("lmpc doctor", "what this computer lacks to drive a car"),
            (
                "lmpc serve; lmpc vehicle sim",
                "controller and car on an LCM network; `lmpc top` watches",
            ),
            ("lmpc hil run bench/quick.toml", "faults and a verdict"),
        ],
    ),
];

/// Prints it.
///
/// # Errors
/// If standard output is closed.
pub fn welcome() -> io::Result<()> {
    let version = env!("CARGO_PKG_VERSION");
    result(&format!("Racing LMPC {version}: a controller that drives faster lap after lap.\n"))?;
    for (whose, commands) in FIRST {
        result(&paint(BEST, whose))?;
        for (command, what) in commands {
            result(&format!("  {command:<34}{}", paint(SOFT, what)))?;
        }
    }
    result("\nEvery command: lmpc --help. One of them with examples: lmpc race --help.")
}
