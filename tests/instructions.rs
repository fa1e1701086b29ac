//! Instructions of a control step and of the solver alone, counted by Valgrind: the same on every run, however busy the
//! machine. The counts of `tests/data/instructions.json` may grow by 5 % before somebody has to
//! look.
//!
//! They are those of one compiler, named beside them, and of a processor with AVX2; with others they
//! may be half as many again. After a change that is worth its instructions renew them:
//! `LMPC_RENEW=1 cargo test --release -p lmpc_tests --test instructions`.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Command;

use serde::{Deserialize, Serialize};
use step_timing::cases;

/// Learned steps that are counted.
const STEPS: u64 = 20;
/// Growth that is let pass with the recorded compiler and AVX2, and with others.
const GROWTH: [f64; 2] = [1.05, 1.5];

/// Instructions of one step, the mean of the counted ones.
fn count(case: usize) -> u64 {
    let arguments = [case.to_string(), STEPS.to_string()];
    counted("step", env!("CARGO_BIN_EXE_drive_under_valgrind"), &arguments) / STEPS
}

/// Instructions of the structured solver on one recorded problem, the mean of all.
fn count_solve() -> u64 {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/qp");
    let problems = std::fs::read_dir(&folder).unwrap().count() as u64;
    let arguments = [folder.display().to_string()];
    counted("solve", env!("CARGO_BIN_EXE_solve_under_valgrind"), &arguments) / problems
}

/// Instructions inside the function `counted_WHAT` of a program.
fn counted(what: &str, program: &str, arguments: &[String]) -> u64 {
    let folder = tempfile::tempdir().unwrap();
    let out = Command::new("valgrind")
        .args(["--tool=callgrind", "--collect-atstart=no"])
        .arg(format!("--toggle-collect=*counted_{what}*"))
        .arg(format!("--callgrind-out-file={}", folder.path().join("out").display()))
        .arg(program)
        .args(arguments)
        .output()
        .unwrap_or_else(|e| {
            panic!("valgrind does not start: {e}; tools/setup.sh test installs it")
        });
    let text = String::from_utf8_lossy(&out.stderr);
    let collected = text.lines().find_map(|line| line.split_once("Collected :"));
    let Some((_, number)) = collected.filter(|_| out.status.success()) else {
        panic!("{}\n{text}", String::from_utf8_lossy(&out.stdout))
    };
    number.trim().parse().unwrap()
}

/// The counts, and the compiler they are of.
#[derive(Serialize, Deserialize)]
struct Recorded {
    compiler: String,
    instructions: BTreeMap<String, u64>,
}

fn compiler() -> String {
    let out = Command::new("rustc").arg("--version").output().unwrap();
    String::from_utf8_lossy(&out.stdout).trim().to_owned()
}

fn has_avx2() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

#[test]
#[cfg_attr(debug_assertions, ignore = "the counts are those of a release build")]
fn instructions_of_a_step() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/instructions.json");
    let mut found: BTreeMap<String, u64> = cases()
        .unwrap()
        .iter()
        .enumerate()
        .map(|(i, case)| (format!("{}, N {}", case.name, case.config.horizon.steps), count(i)))
        .collect();
    found.insert("recorded problems, the solver alone".to_owned(), count_solve());
    for (name, count) in &found {
        println!("{name}: {count} instructions");
        assert!(*count > 100_000, "nothing was counted of {name}");
    }
    if std::env::var_os("LMPC_RENEW").is_some() {
        let renewed = Recorded { compiler: compiler(), instructions: found };
        std::fs::write(&path, serde_json::to_string_pretty(&renewed).unwrap() + "\n").unwrap();
        return;
    }
    let text = std::fs::read_to_string(&path).unwrap();
    let Recorded { compiler: of, instructions: recorded } = serde_json::from_str(&text).unwrap();
    let same = of == compiler() && has_avx2();
    let allowed = GROWTH[usize::from(!same)];
    assert_eq!(
        found.keys().collect::<Vec<_>>(),
        recorded.keys().collect::<Vec<_>>(),
        "the cases have changed: see the top of this file for how to renew the counts"
    );
    for (name, count) in &found {
        let growth = *count as f64 / recorded[name] as f64;
        assert!(
            growth <= allowed,
            "{name}: {count} instructions, {growth:.3} times the recorded {}; see the top \
             of this file for how to renew them",
            recorded[name]
        );
    }
}
