//! `lmpc hil run` against a simulated car in another process, in a network of its own.
#![allow(clippy::unwrap_used, clippy::panic, reason = "code of tests")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use file_check::check_file;

fn bench(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../bench").join(name)
}

/// Runs a bench file with one run of each scenario; what it said and the folder it wrote.
fn run(file: &Path, name: &str, more: &[&str]) -> (Output, PathBuf) {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let mut command = Command::new(env!("CARGO_BIN_EXE_lmpc"));
    command.args(["hil", "run"]).arg(file).args(["--repeats", "1", "--jobs", "1", "--out"]);
    let output = command.arg(&out).args(more).output().unwrap();
    (output, out)
}

#[test]
fn the_shipped_benches_have_no_problems() {
    for name in ["doubt.toml", "faults.toml", "host.toml", "quick.toml", "unforeseen.toml"] {
        assert_eq!(check_file(&bench(name)).problems, vec![], "{name}");
    }
}

#[test]
fn what_must_not_disturb_the_drive_does_not() {
    let more = ["--scenario", "swapped", "--scenario", "incomplete"];
    let (output, out) = run(&bench("quick.toml"), "hil-pass", &more);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && text.ends_with("PASS\n"), "{text} {output:?}");
    let junit = std::fs::read_to_string(out.join("junit.xml")).unwrap();
    assert!(junit.contains("tests=\"2\" failures=\"0\""), "{junit}");
    let page = std::fs::read_to_string(out.join("verdict.html")).unwrap();
    assert!(page.contains("<svg") && !page.contains("http"), "no picture, or one from elsewhere");
}

#[test]
fn a_broken_limit_fails_the_bench_by_name() {
    let text = std::fs::read_to_string(bench("quick.toml")).unwrap();
    let swapped = text.find("name = \"pairs swapped\"").unwrap();
    let (head, tail) = text.split_at(swapped);
    let wrong = tail.replacen("swap = {}", "drop = {}", 1);
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("wrong.toml");
    std::fs::write(&file, format!("{head}{wrong}")).unwrap();
    std::fs::copy(bench("car.toml"), file.with_file_name("car.toml")).unwrap();
    let (output, out) = run(&file, "hil-fail", &["--scenario", "swapped"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.ends_with("FAIL: pairs swapped\n"), "{text}");
    let junit = std::fs::read_to_string(out.join("junit.xml")).unwrap();
    assert!(
        junit.contains("<failure type=\"limit\" message=\"trips: 1.0000, limit &lt;= 0\">"),
        "{junit}"
    );
}

#[test]
fn mistakes_in_a_bench_are_named() {
    let text = std::fs::read_to_string(bench("quick.toml")).unwrap();
    let wrong = text.replacen("processes = [\"car\"]", "processes = [\"cra\"]", 1).replacen(
        "most = 110",
        "least = 2, most = 1",
        1,
    );
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mistakes.toml");
    std::fs::write(&file, wrong).unwrap();
    let problems = check_file(&file).problems;
    let text = format!("{problems:?}");
    assert!(problems.len() == 2 && text.contains("`cra`") && text.contains("least 2"), "{text}");
}

#[test]
fn damaged_logs_and_killed_savers_and_a_missing_route_do_no_harm() {
    let names = ["log cut", "kills while", "no multicast route"];
    let more: Vec<&str> = names.iter().flat_map(|name| ["--scenario", name]).collect();
    let (output, _) = run(&bench("host.toml"), "hil-host", &more);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && text.ends_with("PASS\n"), "{text} {output:?}");
}

#[test]
fn hostile_texts_logs_and_signals_of_a_real_cars_bridge_are_scenarios_that_pass() {
    let names = ["escape sequences", "serve --log", "vehicle car ended by SIGHUP"];
    let more: Vec<&str> = names.iter().flat_map(|name| ["--scenario", name]).collect();
    let (output, _) = run(&bench("doubt.toml"), "hil-doubt", &more);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && text.ends_with("PASS\n"), "{text} {output:?}");
}

/// `bench/doubt.toml` with its scenario `every second command alone comes` for a second, and this as
/// its faults.
fn doubted(name: &str, faults: &str) -> PathBuf {
    let text = std::fs::read_to_string(bench("doubt.toml")).unwrap();
    let at = text.find("name = \"every second command alone comes\"").unwrap();
    let (head, tail) = text.split_at(at);
    let fault = "fault = [{ channel = \"LMPC/CMD\", action = { every = { n = 2 } } }]";
    assert!(tail.contains(fault));
    let tail = tail.replacen(fault, faults, 1).replacen("observe_s = 5", "observe_s = 1", 1);
    let tail = tail.replacen("most = 0 }, { m", "least = 0 }, { m", 1);
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&file, format!("{head}{tail}")).unwrap();
    std::fs::copy(bench("car.toml"), file.with_file_name("car.toml")).unwrap();
    file
}

#[test]
fn a_fault_that_acts_on_nothing_fails_its_scenario() {
    let order =
        |at_s: f64| format!("{{ at_s = {at_s}, action = {{ order = {{ order = \"stop\" }} }} }}");
    let estop = "{ at_s = 0.3, for_s = 0.4, action = { order = { order = \"estop\" } } }";
    for (name, faults, broken) in [
        (
            "misspelt.toml",
            "fault = [{ channel = \"LMPC/CDM\", action = { drop = {} } }]".to_owned(),
            Some("fault 1 acted on no message of LMPC/CDM"),
        ),
        ("two-orders.toml", format!("fault = [{}, {estop}]", order(0.0)), None),
        (
            "covered-order.toml",
            format!("fault = [{}, {}]", order(0.3), order(0.3)),
            Some("the order of fault 1 was never given"),
        ),
    ] {
        let file = doubted(name, &faults);
        let (output, out) = run(&file, &format!("hil-{name}"), &["--scenario", "every second"]);
        assert_eq!(output.status.code(), Some(i32::from(broken.is_some())), "{name} {output:?}");
        let junit = std::fs::read_to_string(out.join("junit.xml")).unwrap();
        assert!(broken.is_none_or(|broken| junit.contains(broken)), "{name}: {junit}");
    }
    let nothing = "fault = [{ channel = \"LMPC/CMD\", share = 0.0, action = { drop = {} } }]";
    let problems = format!("{:?}", check_file(&doubted("no-share.toml", nothing)).problems);
    assert!(problems.contains("share is 0"), "{problems}");
}

/// A bench of one scenario that is a program.
fn program(name: &str, scenario: &str) -> PathBuf {
    let text = std::fs::read_to_string(bench("host.toml")).unwrap();
    let head = &text[..text.find("[[scenario]]").unwrap()];
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&file, format!("{head}[[scenario]]\nname = \"x\"\n{scenario}")).unwrap();
    file
}

#[test]
fn a_program_is_judged_by_what_it_prints_and_how_it_ends() {
    let prints = "program = [\"sh\", \"-c\", \"echo lost {seed}; exit CODE\"]\nsays = [\"WORD\"]\n\
                  [[scenario.expect]]\nmeasure = \"lost\"\nmost = 1\n";
    let good = prints.replace("CODE", "0").replace("WORD", "lost");
    for (name, text, seed, broken) in [
        ("good", good.clone(), "1", None),
        ("limit", good.clone(), "2", Some("lost: 2.0000, limit &lt;= 1")),
        ("code", prints.replace("CODE", "3").replace("WORD", "lost"), "1", Some("exit_code: 3")),
        ("says", prints.replace("CODE", "0").replace("WORD", "won"), "1", Some("`won`")),
    ] {
        let file = program(&format!("program-{name}.toml"), &text);
        let (output, out) = run(&file, &format!("hil-{name}"), &["--seed", seed]);
        assert_eq!(output.status.code(), Some(i32::from(broken.is_some())), "{name} {output:?}");
        let junit = std::fs::read_to_string(out.join("junit.xml")).unwrap();
        assert!(broken.is_none_or(|broken| junit.contains(broken)), "{name}: {junit}");
    }
    let mixed = format!("processes = [\"car\"]\n{good}");
    let observed = "says = [\"x\"]\n[[scenario.expect]]\nmeasure = \"trps\"\nmost = 0\n";
    let no_room = format!("disk_mb = 0\n{good}");
    let no_disk = format!("{good}[[scenario.fault]]\naction = {{ fill_disk = {{}} }}\n");
    for (text, problems) in
        [(mixed.as_str(), 2), (observed, 2), (no_room.as_str(), 1), (no_disk.as_str(), 2)]
    {
        let found = check_file(&program("program-wrong.toml", text)).problems;
        assert_eq!(found.len(), problems, "{found:?}");
    }
}
